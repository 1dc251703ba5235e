"""Write the font for mathematics that pages hold: ``python maths_font.py STIXMath-Regular.otf``.

The source is STIX Math 1.1.1 (SIL Open Font License 1.1; Debian's package fonts-stix has it). What formulas
of symbody can contain is taken from it, with its MATH table, so that brackets and roots grow and dots stand
where they belong; it is renamed, as the licence asks. Needs fonttools and brotli.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

from fontTools import subset
from fontTools.ttLib import TTFont

TARGET: Final = Path(__file__).parents[2] / "src/symbody/display/maths.woff2"
FAMILY: Final = "Symbody Math"
CLEARANCE: Final = 120  # thousandths of the size: accents stand higher, or dots touch tall letters at 16 px
LINE: Final = (
    800,
    250,
)  # thousandths above and below the base line: Firefox makes rows as high as the font says
MOST_BYTES: Final = 60_000
_LICENSE: Final = {13: "SIL Open Font License 1.1", 14: "https://openfontlicense.org"}
_SIGNS: Final = (
    "\u00a0\u00a8\u00ac\u00b0\u00b1\u00b2\u00b3\u00b5\u00b7\u00d7\u00f7\u02d9\u0307\u0308\u2013\u2026\u2032\u2033"
    "\u2061\u2062\u2202\u2206\u2207\u2208\u2211\u2212\u221a\u221e\u2220\u2225\u2227\u2228\u222b\u2248\u2260"
    "\u2264\u2265\u22a4\u2308\u2309\u230a\u230b\u20db\u20dc\u2192\u210e"
)


def characters() -> set[int]:
    """Return what formulas contain: Latin and Greek, upright and italic as browsers set single letters."""
    latin, greek = range(0x20, 0x7F), [*range(0x391, 0x3AA), *range(0x3B1, 0x3CA), 0x3D1, 0x3D5, 0x3F5]
    italic = [*range(0x1D434, 0x1D468), *range(0x1D6E2, 0x1D71C)]
    return {*latin, *greek, *italic, *map(ord, _SIGNS)}


def write_font(source: Path, target: Path = TARGET) -> int:
    """Write the font and return its bytes.

    Raises
    ------
    ValueError
        If it is larger than pages may hold.
    """
    font = TTFont(source)
    features = ["ssty", "kern", "dtls"]
    options = subset.Options(flavor="woff2", layout_features=features, hinting=False, notdef_outline=True)
    options.name_IDs = ["*"]
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=characters())
    subsetter.subset(font)
    for record in list(font["name"].names):
        if record.nameID in (1, 3, 4, 6, 16):
            record.string = FAMILY.replace(" ", "") if record.nameID == 6 else FAMILY
        elif record.nameID in _LICENSE:
            record.string = _LICENSE[record.nameID]
        elif record.nameID not in (0, 2):
            font["name"].names.remove(record)
    _set_line_height(font)
    constants = font["MATH"].table.MathConstants
    constants.AccentBaseHeight.Value -= CLEARANCE
    font["CFF "].cff.fontNames[0] = FAMILY.replace(" ", "")
    subset.save_font(font, target, options)
    size = target.stat().st_size
    if size > MOST_BYTES:
        raise ValueError(f"{target.name} has {size} bytes, at most {MOST_BYTES}")
    return size


def _set_line_height(font: TTFont) -> None:
    """Make a line as high as one of text: the source's covers its tallest brackets, three times as much."""
    above, below = LINE
    font["hhea"].ascent, font["hhea"].descent, font["hhea"].lineGap = above, -below, 0
    table = font["OS/2"]
    table.usWinAscent, table.usWinDescent = above, below
    table.sTypoAscender, table.sTypoDescender, table.sTypoLineGap = above, -below, 0


if __name__ == "__main__":
    print(f"{TARGET.name}: {write_font(Path(sys.argv[1])) / 1000:.1f} kB")
