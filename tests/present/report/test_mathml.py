"""Formulas: what becomes MathML, and what stays as its source."""

import html
from xml.etree import ElementTree

import pytest

from rigsim.present.report.mathml import mathml


def text_of(mathml_text):
    """What is written, in reading order, without the gaps."""
    return "".join(ElementTree.fromstring(mathml_text.replace("&nbsp;", " ")).itertext()).replace(" ", "")


@pytest.mark.parametrize(
    ("latex", "written"),
    [
        (r"\frac{9}{16}\gamma^2", "916γ2"),
        (r"\mathrm{N/m^3}", "N/m3"),
        (r"\operatorname{Re}(U e^{i \omega t})", "Re(Ueiωt)"),
        (r"x = 1 \tag{3a}", "x=1(3a)"),
        (r"\begin{align} a &= b \tag{1} \\[2pt] c &= d \label{eq:d} \end{align}", "a=b(1)c=d"),
        (r"\begin{aligned} a &= b \\ c &= d \end{aligned}", "a=bc=d"),
        (r"\begin{equation} x < 1 \end{equation}", "x<1"),
        (r"\begin{cases} 1 & x > 0 \\ 0 & \text{else} \end{cases}", "{1x>00else"),
        (r"\begin{bmatrix} a & b \\ c & d \end{bmatrix}", "[abcd]"),
    ],
)
def test_maths_becomes_mathml(latex, written):
    result = mathml(latex, display=True)
    assert "<math" in result
    assert text_of(result).replace("\u2003", "") == written


@pytest.mark.parametrize("latex", [r"\nosuchcommand{x}", r"a \begin{align} b", "x & y", r"\frac{a}{", "}", ""])
def test_maths_that_cannot_be_converted_stays_readable(latex):
    result = mathml(latex, display=True)
    ElementTree.fromstring(result)
    assert "<math" in result or html.escape(latex) in result


def test_units_stand_upright():
    assert "<mi>Hz</mi>" in mathml(r"3\,\mathrm{Hz}")
    assert '<mi mathvariant="normal">' in mathml(r"3\,\mathrm{N}")
    assert '<mi mathvariant="normal">' not in mathml("N")
