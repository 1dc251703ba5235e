"""Colours as users write them: ``"#rrggbb"``, or a name of the CSS Color Module Level 4."""

from __future__ import annotations

import re
from typing import Final

from symbody.errors import nearest
from symbody.model.door import Door

_HEX: Final = re.compile(r"#[0-9a-fA-F]{6}")

CSS_COLORS: Final = frozenset(
    """
    aliceblue antiquewhite aqua aquamarine azure beige bisque black blanchedalmond blue blueviolet brown
    burlywood cadetblue chartreuse chocolate coral cornflowerblue cornsilk crimson cyan darkblue darkcyan
    darkgoldenrod darkgray darkgreen darkgrey darkkhaki darkmagenta darkolivegreen darkorange darkorchid
    darkred darksalmon darkseagreen darkslateblue darkslategray darkslategrey darkturquoise darkviolet
    deeppink deepskyblue dimgray dimgrey dodgerblue firebrick floralwhite forestgreen fuchsia gainsboro
    ghostwhite gold goldenrod gray green greenyellow grey honeydew hotpink indianred indigo ivory khaki
    lavender lavenderblush lawngreen lemonchiffon lightblue lightcoral lightcyan lightgoldenrodyellow
    lightgray lightgreen lightgrey lightpink lightsalmon lightseagreen lightskyblue lightslategray
    lightslategrey lightsteelblue lightyellow lime limegreen linen magenta maroon mediumaquamarine mediumblue
    mediumorchid mediumpurple mediumseagreen mediumslateblue mediumspringgreen mediumturquoise
    mediumvioletred midnightblue mintcream mistyrose moccasin navajowhite navy oldlace olive olivedrab orange
    orangered orchid palegoldenrod palegreen paleturquoise palevioletred papayawhip peachpuff peru pink plum
    powderblue purple rebeccapurple red rosybrown royalblue saddlebrown salmon sandybrown seagreen seashell
    sienna silver skyblue slateblue slategray slategrey snow springgreen steelblue tan teal thistle tomato
    turquoise violet wheat white whitesmoke yellow yellowgreen
    """.split()
)


def color_from(door: Door, value: object, path: str) -> str:
    """Return a colour in lower case; "" stands for the usual one."""
    text = value.strip().lower() if isinstance(value, str) else None
    if text is not None and (not text or _HEX.fullmatch(text) or text in CSS_COLORS):
        return text
    cure = 'write "#rrggbb" in hexadecimal, such as "#d55e00", or a name such as "orange"'
    if text and not text.startswith("#"):
        cure = f"{nearest(text, CSS_COLORS)} Or {cure}"
    door.refuse("model.bad_color", path, f"{value!r} is not a colour", "", cure)
    return ""
