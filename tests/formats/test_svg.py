"""SVG: shapes, transforms, units, layers, and documents that are refused."""

import math

import numpy as np
import pytest

from cutgap.instances.formats.drawings.worker import read
from cutgap.instances.formats.options import DrawingOptions

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
)
SIZE = 'width="200mm" height="100mm" viewBox="0 0 200 100">'


def svg(body, size=SIZE) -> bytes:
    return (HEAD + size + body + "</svg>").encode()


def outlines(body, size=SIZE, **options):
    return read("svg", svg(body, size), DrawingOptions(**options))[0]


def single(body, size=SIZE, **options):
    (found,) = outlines(body, size, **options)
    return found


SHAPES = [
    ('<rect x="10" y="10" width="30" height="20"/>', 100),
    ('<rect x="10" y="10" width="30" height="20" rx="5"/>', 60 + 10 * math.pi),
    ('<circle cx="50" cy="50" r="10"/>', 20 * math.pi),
    ('<ellipse cx="50" cy="50" rx="10" ry="10"/>', 20 * math.pi),
    ('<polygon points="0,0 30,0 30,40"/>', 120),
    ('<polyline points="0,0 30,0 30,40 0,0"/>', 120),
    ('<path d="M 0 0 H 30 V 40 Z"/>', 120),
    ('<path d="M 0 0 h 20 a 5 5 0 0 1 0 10 h -20 z"/>', 50 + 5 * math.pi),
    ('<line x1="0" y1="0" x2="30" y2="0"/><path d="M 30 40 L 30 0 M 30 40 L 0 0"/>', 120),
    ('<g transform="rotate(30 50 50)"><rect width="30" height="20"/></g>', 100),
    ('<rect width="30" height="20" transform="translate(9 9) scale(2) skewX(0)"/>', 200),
    ('<circle r="5mm"/>', 10 * 96 / 25.4 * math.pi),
    ('<circle r="10" transform="matrix(0 1 -1 0 40 40)"/>', 20 * math.pi),
    ('<defs><rect id="a" width="30" height="20"/></defs><use href="#a" x="40"/>', 100),
    (
        '<defs><g id="a"><rect width="30" height="20"/></g></defs><use xlink:href="#a" transform="scale(.5)"/>',
        50,
    ),
]


@pytest.mark.parametrize(("body", "perimeter"), SHAPES)
def test_shapes_are_as_long_as_they_are(body, perimeter):
    assert single(body).perimeter == pytest.approx(perimeter, rel=1e-9)


def test_bezier_curves_keep_to_their_ends_and_heights():
    found = single('<path d="M 0 100 C 0 60 40 60 40 100 Z"/>')
    assert found.points[:, 1].min() == pytest.approx(0, abs=1e-9)
    assert found.points[:, 1].max() == pytest.approx(30, abs=0.01)
    found = single('<path d="M 0 100 Q 20 60 40 100 Z"/>')
    assert found.points[:, 1].max() == pytest.approx(20, abs=0.01)
    assert len(found.corners) == 2


def test_y_goes_up_from_the_lower_edge():
    found = single('<rect x="10" y="5" width="30" height="20"/>')
    assert found.points.min(axis=0) == pytest.approx((10, 75))
    assert found.points.max(axis=0) == pytest.approx((40, 95))


@pytest.mark.parametrize(
    ("size", "factor"),
    [
        ('width="10cm" height="10cm" viewBox="0 0 100 100">', 1.0),
        ('width="1in" height="1in" viewBox="0 0 100 100">', 0.254),
        ('width="96" height="96">', 25.4 / 96),
        ('width="96px" height="96px" viewBox="0 0 192 192">', 25.4 / 192),
        ('viewBox="0 0 100 100">', 25.4 / 96),
    ],
)
def test_units_become_mm(size, factor):
    found = single('<rect x="10" y="10" width="30" height="20"/>', size)
    assert found.perimeter == pytest.approx(100 * factor)
    assert np.ptp(found.points, axis=0) == pytest.approx((30 * factor, 20 * factor))


def test_layers_are_the_groups_at_the_top():
    body = (
        '<g id="g1" inkscape:label="Cut"><g id="inner"><rect width="30" height="20"/></g></g>'
        '<g id="marks"><rect x="50" width="30" height="20"/></g><rect x="100" width="30" height="20"/>'
    )
    assert [each.layer for each in outlines(body)] == ["Cut", "marks", "0"]
    assert [each.layer for each in outlines(body, layers=("Cut",))] == ["Cut"]
    with pytest.raises(ValueError, match=r"no layer 'cuts'; the drawing has Cut, marks, 0"):
        outlines(body, layers=("cuts",))


def test_what_is_not_drawn_is_left_out():
    body = (
        '<rect width="30" height="20"/><rect x="50" width="30" height="20" style="display:none"/>'
        '<rect x="50" width="30" height="20" visibility="hidden"/><text>part</text>'
        '<clipPath id="c"><rect x="90" width="30" height="20"/></clipPath>'
    )
    found, notes = read("svg", svg(body), DrawingOptions())
    assert len(found) == 1
    assert any("1 clipPath, 1 text" in note for note in notes)
    assert any("hidden, left out" in note for note in notes)


BAD = [
    (svg('<path d="M 0 0 L 30 0 30 x 20"/>'), r"path 'number 1': cannot read its d: 'M 0 0 L 30 0 30 x 20'"),
    (b"", r"line 1: not XML"),
    (b"<svg><rect></svg>", r"line 1: not XML: mismatched tag"),
    (b"<html/>", r"not an SVG file: its root is 'html'"),
    (b'<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><svg>&b;</svg>', "remove the DOCTYPE"),
    ('<!DOCTYPE svg [<!ENTITY a "a">]><svg>&a;</svg>'.encode("utf-16"), "remove the DOCTYPE"),
    (b'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg>&a;</svg>', "remove the DOCTYPE"),
    (svg('<use href="#none"/>'), "nothing in the file is called '#none'"),
    (svg('<use href="other.svg#a"/>'), "nothing in the file is called 'other.svg#a'"),
    (svg('<symbol id="s"/>'), "symbol 's'"),
    (svg(""), r"no closed contour in the drawing; .* \(it is empty\)"),
    (
        (HEAD + SIZE + '<path d="M 0 0 L 30 0"/></svg>').encode(),
        r"open: layer '0', path number 1, from \(0, 100\)",
    ),
    (
        (HEAD + SIZE + '<circle r="1e300"/></svg>').encode(),
        r"circle number 1: has a coordinate of .* the most is",
    ),
]


@pytest.mark.parametrize(("content", "message"), BAD)
def test_bad_files_are_refused(content, message):
    with pytest.raises(ValueError, match=message):
        read("svg", content, DrawingOptions())


def test_a_plain_doctype_is_taken():
    doctype = (
        '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
    )
    content = doctype.encode() + svg('<rect width="30" height="20"/>')
    assert len(read("svg", content, DrawingOptions())[0]) == 1
