"""The step of a test under feedback, from what was measured to what is to be held next, by a model's linear balance.

Measured are the lines of y = (xs, x) at the multiples n of the frequency, and of the feedback's part of the force. The
model is linearised about the measured motion, so that lines answer to each other through those of its slope
k1 + 3 k3 z(t)^2. Asked is for the motion with the feedback's lines gone at every n but 1, with the first line of z at a
given amplitude and phase 0, and with whatever force at n = 1 that takes:

    (-n^2 w^2 M + i n w C) dY_n + sum over m of K_{n-m} dY_m = (1, 0) df_n,     df_n = -feedback_n for n other than 1,
    dXs_1 - dX_1 = amplitude - Z_1.

Where the amplitude is the one that was held, this is a step of Newton's method towards a feedback that adds nothing;
where it is another, it is a step along the curve of motions as well, taken in short parts, each about the motion that
the last one led to. Bordered so, the equations are regular at folds of the response, where the amplitude at a given
force is not.
"""

import numpy as np

from ...model.oscillator import matrices

_PART = 0.05  # longest part of a step, over the larger amplitude


def stepped(model, frequency, lines, feedback, amplitude):
    """The motion's lines (H + 1, 2) and what is added to the force's first line, complex.

    ``lines`` (H + 1, 2) complex are the mean and harmonics of xs and x as measured (m), ``feedback`` (H + 1,) those of
    the feedback's force (N), ``amplitude`` is of z (m) and ``frequency`` in Hz.
    """
    first, added = lines[1, 0] - lines[1, 1], 0j
    parts = max(1, int(np.ceil(abs(amplitude - first) / (_PART * max(amplitude, abs(first))))))
    for part in range(1, parts + 1):
        lines, more = _linear_step(model, frequency, lines, feedback, first + (amplitude - first) * part / parts)
        added, feedback = added + more, np.zeros_like(feedback)  # which is gone with the first
    return lines, added


def _linear_step(model, frequency, lines, feedback, first):
    """`stepped` in one part, to the first line ``first`` of z."""
    highest = len(lines) - 1
    count = 2 * highest + 1
    slope = _slope(model, lines[:, 0] - lines[:, 1], 2 * highest)
    mass, damping, stiffness = matrices(model)
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    orders = np.arange(-highest, highest + 1)
    system = np.zeros((2 * count + 2, 2 * count + 2), dtype=complex)
    blocks = np.kron(slope[np.subtract.outer(orders, orders)], between)
    for i, s in enumerate(2j * np.pi * frequency * orders):
        blocks[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += s**2 * mass + s * damping + stiffness
    system[:-2, :-2] = blocks
    right = np.zeros(2 * count + 2, dtype=complex)
    right[:-2:2] = -_both_sides(feedback)
    for row, i in enumerate((highest + 1, highest - 1)):  # orders 1 and -1
        system[2 * i, 2 * count + row] = -1.0
        system[2 * count + row, 2 * i : 2 * i + 2] = 1.0, -1.0
        right[2 * i] = 0.0
    change = (first - lines[1, 0] + lines[1, 1]) / 2
    right[-2:] = change, np.conj(change)
    found = np.linalg.solve(system, right)
    change = found[:-2].reshape(count, 2)[highest:]
    change[1:] *= 2
    return lines + change, 2 * found[-2]


def largest_amplitude(model, frequency, force):
    """Largest amplitude of z (m) that one harmonic of the model gives to a force (N) at a frequency (Hz)."""
    alpha, beta = single_term(model, frequency)
    squared = np.roots([abs(beta) ** 2, 2 * (alpha * np.conj(beta)).real, abs(alpha) ** 2, -(force**2)])
    return float(np.sqrt(squared.real[abs(squared.imag) < 1e-6 * abs(squared)].max()))


def single_term(model, frequency):
    """Complex alpha (N/m) and beta (N/m^3) of the force F = a (alpha + beta a^2) that z = a cos takes, one harmonic.

    The mass's equation gives X, the frame's then the force.
    """
    s = 2j * np.pi * frequency
    frame, inertia = model.ms * s**2 + model.cs * s + model.ks, model.m * s**2
    linear, cubic = s * model.c + model.k1, 0.75 * model.k3
    return frame * (1 + linear / inertia) + linear, cubic * (frame / inertia + 1)


def phase_slope(model, frequency, amplitude):
    """How the phase of z against the force changes with frequency at an amplitude of z that stays (rad/Hz)."""
    step = 1e-4 * frequency
    beside = [
        np.angle(alpha + beta * amplitude**2)
        for alpha, beta in (single_term(model, frequency + d) for d in (-step, step))
    ]
    return -float((beside[1] - beside[0] + np.pi) % (2 * np.pi) - np.pi) / (2 * step)


def misfit(model, frequency, lines):
    """What the model's suspension leaves of the mass's inertia force at the frequency, over that force.

    No feedback acts on the mass, so this is the model's own error.
    """
    terms, inertia = _mass_equation(model, frequency, lines)
    return float(abs(inertia[0] - terms[0] @ [model.c, model.k1, model.k3]) / abs(inertia[0]))


def refitted(model, frequency, motions):
    """The model with c, k1 and k3 as motions (lines (H + 1, 2) each) at a frequency tell them by least squares.

    From the mass's equation, on which no force acts from outside, at the multiples 1 to 5; m is the model's. What is
    less than zero becomes zero.
    """
    terms, inertia = (
        np.concatenate(parts) for parts in zip(*(_mass_equation(model, frequency, one) for one in motions), strict=True)
    )
    terms, inertia = (np.concatenate([part.real, part.imag]) for part in (terms, inertia))
    scale = np.linalg.norm(terms, axis=0)
    c, k1, k3 = np.maximum(np.linalg.lstsq(terms / scale, inertia, rcond=None)[0] / scale, 0.0)
    return model.replace(c=float(c), k1=float(k1), k3=float(k3))


def _mass_equation(model, frequency, lines):
    """Of m x'' = c z' + k1 z + k3 z^3 the lines 1 to 5 of z', z and z^3 (5, 3), and of the left side, each over n^2.

    So divided, a sensor's noise is alike in all of them.
    """
    n = np.arange(1, 6)
    s = 2j * np.pi * frequency * n
    relative = lines[:, 0] - lines[:, 1]
    cubed = _sampled(relative, 8 * len(relative)) ** 3
    cubic = 2 * np.fft.fft(cubed)[n] / len(cubed)
    terms = np.column_stack([s * relative[n], relative[n], cubic])
    return terms / n[:, None] ** 2, model.m * s**2 * lines[n, 1] / n**2


def _slope(model, relative, highest):
    """Lines -highest to highest of 3 k3 z^2 in the order of a FFT (index n counts from the end where n < 0)."""
    z = _sampled(relative, 4 * highest)
    return np.fft.fft(3 * model.k3 * z**2) / len(z)


def _sampled(relative, count):
    phase = 2 * np.pi * np.arange(count) / count
    return (relative * np.exp(1j * np.outer(phase, np.arange(len(relative))))).real.sum(axis=1)


def _both_sides(line):
    """Coefficients at -H to H of the real signal whose lines, mean first, are given."""
    half = np.append(line[:1], line[1:] / 2)
    return np.concatenate([np.conj(half[:0:-1]), half])
