"""Small notebooks with everything a report has to cope with."""

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

FIRST = [
    new_markdown_cell(
        "# Does the first page move?\n\nIt **does**, at $F = 3.18\\,\\mathrm{N}$ and above. A second sentence.\n\n"
        "## Equations\n\nInline $W^2 |\\mu\\Omega^4 - D N|^2 = \\Omega^4$, a price of \\$5, code `$x$` and `$$y$$`.\n\n"
        "$$ a W^6 + b W^4 + c W^2 + d = 0 \\tag{5a} $$\n\n"
        "\\begin{align}\n m_s \\ddot{x}_s + c_s \\dot{x}_s + k_s x_s &= f(t) \\tag{3a} \\\\\n"
        " \\gamma_\\mp &= \\frac{8 e}{81 X^2} \\left[ -r (r^2 + 9 s^2) \\mp (r^2 - 3 s^2)^{3/2} \\right] \\tag{3b}\n"
        "\\end{align}\n\n"
        "$$ v = \\begin{cases} 1 & x > 0 \\\\ 0 & \\text{else} \\end{cases} $$\n\n"
        "| quantity | printed | computed |\n|---|---|---|\n| k1 | 28.235 | 28.2353 |\n\n"
        "On to [the second](02_second.ipynb#What-else), or [elsewhere](https://example.org/page.ipynb)."
    ),
    new_code_cell(
        "import sys\n\nimport ipywidgets\nimport numpy as np\nimport pandas as pd\nfrom tqdm.auto import tqdm\n\n"
        "from rigsim.present.figures.style import style, subplots\n"
        "from rigsim.present.moving.plot import Curve, MovingPlot, Panel\n"
        "from rigsim.present.moving.shapes import Shape, animate"
    ),
    new_markdown_cell("## Figures"),
    new_code_cell(
        "print('printed')\nprint('warned', file=sys.stderr)\n[None for _ in tqdm(range(3), desc='counting')]\n"
        "with style():\n"
        "    figure, axes = subplots(alt='A straight line that rises')\n"
        "    axes.plot([0, 1], [0, 1])\n    axes.set(xlabel='time [s]', ylabel='x [mm]', title='Line')\n"
        "figure"
    ),
    new_code_cell(
        "with style():\n    figure, axes = subplots(1, 2, alt='Two lines that fall')\n    axes[0].plot([1, 0])\n"
        "    axes[1].plot([1, 0, 0.5])\nfigure"
    ),
    new_markdown_cell("## Motion"),
    new_code_cell(
        "frequency = np.linspace(10, 80, 500)\nforces = np.linspace(0.5, 6, 12)\n\n\ndef curves(force, scale):\n"
        "    ratio = frequency / 50\n    size = scale * force / np.hypot(1 - ratio**2, 0.1 * ratio)\n"
        "    return [Curve(frequency, size, 'stable', 'stable'),\n"
        "            Curve(frequency, 3 * size, 'unstable', 'unstable')][: 1 + (force > 3)]\n\n\n"
        "panels = [Panel([curves(force, scale) for force in forces], 'frequency [Hz]', f'{name} [mm]', yscale='log')\n"
        "          for name, scale in [('xs', 1), ('x', 2), ('z', 3)]]\n"
        "notes = [f'{1 + (force > 3)} curves' for force in forces]\n"
        "MovingPlot('Force', forces, 'N', panels, alt='Response that grows with the force', notes=notes)"
    ),
    new_code_cell(
        "time = np.linspace(0, 0.02, 50)\nangle = 0.2 * np.sin(400 * time)[:, None]\nx, y = np.array([[-1, 1, 1, -1], "
        "[-1, -1, 1, 1]]) * [[0.0125], [0.004]]\n"
        "body = np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)], axis=-1)\n"
        "animate(time, [Shape(body, 'outline', 'mass'), Shape([[-0.02, 0.01], [0.02, 0.01]], label='frame')],\n"
        "        alt='A body that rocks', caption='Tilt drawn 10 times as large.')"
    ),
    new_markdown_cell("## Tables and panels"),
    new_code_cell("pd.DataFrame({f'column {i}': [1.5, 2.5] for i in range(15)}, index=['xs', 'x'])"),
    new_code_cell(
        "slider = ipywidgets.FloatSlider(description='Force')\ndisplay(slider)\n"
        "ipywidgets.VBox([ipywidgets.FloatSlider(description='Tension')])"
    ),
]
SECOND = [
    new_markdown_cell("# Second\n\nWhat is left? Little."),
    new_markdown_cell("## What else\n\nBack to [the first](01_first.ipynb)."),
    new_code_cell("import sys\nsys.executable"),
]
FAILING = [
    new_markdown_cell("# Failing\n\nWhat goes wrong?"),
    new_code_cell("pass"),
    new_code_cell("print('half a page')\nraise ArithmeticError('two lines\\nof woe')"),
    new_code_cell("pass"),
]


def write_notebook(path, cells):
    kernel = {"name": "python3", "display_name": "Python 3 (ipykernel)", "language": "python"}
    nbformat.write(new_notebook(cells=cells, metadata={"kernelspec": kernel}), path)
