"""Links of the built site that lead nowhere, and what it fetches from a network: ``check_links.py SITE``."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

FETCHED = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src"}


class Page(HTMLParser):
    """The links and anchors of one page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[tuple[str, str]] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the link and the anchor of one tag."""
        given = dict(attrs)
        if place := given.get("id"):
            self.anchors.add(place)
        if link := given.get("href" if tag == "a" else FETCHED.get(tag, "")):
            self.links.append((tag, link))


def faults(folder: Path) -> Iterator[str]:
    """Yield a line for each link that leads nowhere or out of the folder without being asked for."""
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in folder.rglob("*.html")}
    for path, page in pages.items():
        for tag, link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                if tag != "a" and parts.scheme != "data":
                    yield f"{path.name}: {tag} is fetched from {link}"
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                yield f"{path.name}: {link} does not exist"
            elif parts.fragment and target in pages and parts.fragment not in pages[target].anchors:
                yield f"{path.name}: {link} has no such place"


if __name__ == "__main__":
    lines = sorted(set(faults(Path(sys.argv[1]))))
    print("\n".join(lines) or "all links lead somewhere")
    sys.exit(bool(lines))
