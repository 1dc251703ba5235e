"""Rewrite docs/references.md from docs/references.bib: ``python docs/list_references.py``.

Pages and docstrings cite by surnames and year, "Featherstone (2008)"; tests/test_references.py looks each up.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).parent
ENTRY = re.compile(r"@(\w+)\{(\w+),\n(.*?)\n\}", re.DOTALL)
FIELD = re.compile(r"^  (\w+) = \{(.*)\},?$", re.MULTILINE)
# Where a source is found, by the names of its fields: what stands together, then what commas part.
WHERE = (("journal", "volume"), ("booktitle",), ("series", "number"), ("publisher",), ("pages",))
HEAD = """# References

The sources that pages and docstrings name by author and year, made from [references.bib](references.bib) by
`python docs/list_references.py`. How to cite symbody itself: [CITATION.cff](../CITATION.cff). An entry has
a DOI where other publications were seen to give the same one for that title.
"""


@dataclass(frozen=True)
class Reference:
    """One entry.

    Attributes
    ----------
    fields : dict of str
        By their names in BibTeX.
    """

    key: str
    kind: str
    fields: dict[str, str]

    @property
    def authors(self) -> list[str]:
        """Names as "Surname, Given"."""
        return self.fields["author"].split(" and ")

    @property
    def surnames(self) -> list[str]:
        """Of the authors."""
        return [name.partition(",")[0] for name in self.authors if name != "others"]

    def line(self) -> str:
        """Return the entry as a row of the page."""
        fields = self.fields
        parts = (" ".join(fields[name] for name in part if name in fields) for part in WHERE)
        where = ", ".join(filter(None, parts)).replace("--", "-")
        names = ", ".join("et al." if name == "others" else _reversed(name) for name in self.authors)
        doi = f" [doi:{fields['doi']}](https://doi.org/{_quoted(fields['doi'])})" if "doi" in fields else ""
        return f"- {names}: *{fields['title']}*. {where}, {fields['year']}.{doi}"


def references() -> list[Reference]:
    """Return all entries in the order of authors and years."""
    text = (DOCS / "references.bib").read_text("utf-8")
    found = [Reference(key, kind, dict(FIELD.findall(body))) for kind, key, body in ENTRY.findall(text)]
    return sorted(found, key=lambda each: ([name.casefold() for name in each.surnames], each.fields["year"]))


def page() -> str:
    """Return the text of the page."""
    return HEAD + "\n" + "\n".join(each.line() for each in references()) + "\n"


def _reversed(name: str) -> str:
    surname, _, given = name.partition(", ")
    return f"{given} {surname}" if given else surname


def _quoted(doi: str) -> str:
    return doi.replace("(", "%28").replace(")", "%29")


if __name__ == "__main__":
    (DOCS / "references.md").write_text(page(), encoding="utf-8")
