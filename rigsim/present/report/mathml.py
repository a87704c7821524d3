"""LaTeX to MathML at export, so that a page shows its formulas without a script."""

import re
from html import escape

from latex2mathml.converter import convert as _latex_to_mathml


def mathml(latex, display=False):
    r"""LaTeX maths as a MathML element, or, where it cannot be converted, as its source in a ``<code>`` element.

    Parameters
    ----------
    latex : str
        Without dollar signs. Environments of several lines and ``\tag`` are understood.
    display : bool
        On a line of its own.

    Returns
    -------
    str
    """
    text = re.sub(r"\\(label|notag|nonumber)\b(\{[^}]*\})?", "", latex).strip()
    text = re.sub(r"\\(begin|end)\{(equation|displaymath)\*?\}", "", text)
    # The converter knows one environment of several lines that carries no running numbers: split.
    text = re.sub(r"\\(begin|end)\{(align|aligned|gather|gathered|eqnarray|multline)\*?\}", r"\\\1{split}", text)
    text = re.sub(r"\\\\\s*\[[^\]]*\]", r"\\\\", text)
    tags = re.findall(r"\\tag\*?\{([^}]*)\}", text)
    several = r"\begin{split}" in text
    if several:
        text = re.sub(r"\\tag\*?\{([^}]*)\}", r"& \\qquad\\text{(\1)}", text)
    else:
        text = re.sub(r"\\tag\*?\{[^}]*\}", "", text)
    try:
        result = _latex_to_mathml(text, display="block" if display else "inline")
    except Exception:  # whatever the converter stumbles over, the reader still gets the source
        result = ""
    # Commands it does not know come through as their own names, stray alignment marks unescaped.
    if not result or re.search(r">\\[A-Za-z]|>&<", result):
        return f'<code class="tex">{escape(latex.strip())}</code>'
    # One upright letter comes as a character reference that has lost its uprightness; those of a longer word belong
    # together in one element. A bar is a fence, not an operator with space around it.
    upright = '<mi mathvariant="normal">'
    result = re.sub(r"<mi>(&#x000[4-7][0-9A-F];)</mi>", rf"{upright}\1</mi>", result)
    word = rf"(?:{upright}\w</mi>){{2,}}"
    result = re.sub(word, lambda run: f"<mi>{re.sub('<[^>]*>', '', run[0])}</mi>", result)
    result = result.replace('<mo stretchy="false">&#x0007C;', '<mo stretchy="false" lspace="0" rspace="0">&#x0007C;')
    if display:
        tag = f'<span class="tag">({escape(", ".join(tags))})</span>' if tags and not several else ""
        return f'<span class="maths">{result}{tag}</span>'
    return result
