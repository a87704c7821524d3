"""A page that would load something is refused; links are not."""

import pytest

from rigsim.present.report.run import ReportError
from rigsim.present.report.self_contained import check_self_contained


@pytest.mark.parametrize(
    "page",
    [
        '<script src="https://x.y/z.js"></script>', '<link rel="stylesheet" href="z.css">', "<img srcset='z.png 2x'>",
        "<style>@import 'z.css';</style>", "<style>a { background: url(https://x.y/z.png) }</style>",
        "<p style=\"background: url('z.png')\">", '<svg><use xlink:href="z.svg#a"/></svg>',
        "<iframe src=z.html></iframe>",
    ],
)  # fmt: skip
def test_whatever_would_load_something_is_refused(page):
    with pytest.raises(ReportError, match="would load"):
        check_self_contained(page, "x")


def test_links_and_data_are_not_refused():
    check_self_contained('<a href="https://x.y">a</a><img src="data:,"><use href="#a"/><g clip-path="url(#a)"/>', "x")
