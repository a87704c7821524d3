"""A page that would load something is refused; links are not."""

import base64
import hashlib

import pytest
from bs4 import BeautifulSoup

from rigsim.present.report.run import ReportError
from rigsim.present.report.self_contained import check_self_contained, seal


@pytest.mark.parametrize(
    "page",
    [
        '<script src="https://x.y/z.js"></script>', '<link rel="stylesheet" href="z.css">', "<img srcset='z.png 2x'>",
        "<style>@import 'z.css';</style>", "<style>a { background: url(https://x.y/z.png) }</style>",
        "<p style=\"background: url('z.png')\">", '<svg><use xlink:href="z.svg#a"/></svg>',
        "<iframe src=z.html></iframe>", "<meta http-equiv='Refresh' content='0; url=https://x.y'>",
    ],
)  # fmt: skip
def test_whatever_would_load_something_is_refused(page):
    with pytest.raises(ReportError, match="would load"):
        check_self_contained(page, "x")


def test_links_and_data_are_not_refused():
    check_self_contained('<a href="https://x.y">a</a><img src="data:,"><use href="#a"/><g clip-path="url(#a)"/>', "x")


def policy_of(page):
    soup = BeautifulSoup(page, "html.parser")
    return soup.find("meta", attrs={"http-equiv": "Content-Security-Policy"})["content"]


def test_a_sealed_page_lets_in_nothing_but_its_own_scripts():
    head, script = '<!DOCTYPE html><head>\n<meta charset="utf-8">', "one();\r\ntwo('<b>');"
    policy = policy_of(seal(f"{head}</head><script>{script}</script>", "x"))
    assert policy.startswith("default-src 'none'; ") and "http" not in policy and "unsafe-eval" not in policy
    digest = base64.b64encode(hashlib.sha256(script.replace("\r", "").encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}';" in policy
    assert "script-src 'none'" in policy_of(seal(head, "x"))
    with pytest.raises(ReportError, match="would load"):
        seal(head + "<img src=x.png>", "x")
