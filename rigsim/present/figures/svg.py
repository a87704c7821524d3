"""Several SVG drawings on one page: keep their ids apart."""

import re

_ID = re.compile(r"""(\bid=["']|\bhref=["']#|url\(["']?#)""")


def unique_ids(text, prefix):
    """Put ``prefix`` before every id of an SVG text and before every reference to one.

    Matplotlib names its glyphs and clips alike in every figure, so that the second figure of a page would be cut by
    the clip of the first. The text may be HTML that contains SVG; a prefix is letters, digits and hyphens, a letter
    first.
    """
    return _ID.sub(lambda match: match[1] + prefix, text)
