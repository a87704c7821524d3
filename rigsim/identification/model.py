"""The state-space model of a record with its springs' force as an input, Eq. (8): steps 1 and 2 of `identify`."""

from dataclasses import replace

import numpy as np

from ..experiment.joints import slices
from . import nsi
from .layout import displacing, layout_of, outputs_of, powers_of
from .receptance import frequencies
from .refine import fit_to_lines, refine_state_space
from .subspace import dynamics, extended_gram, fit_input_matrices


def extended_model(record, order, block_rows, band, report, relative=None):
    """Model of a record with u = [f, -z^3]; ``report`` is told the steps done.

    The z that a first model gives is without the measurement's noise, which its cube is biased by. But where
    the nonlinear force is strong that model's error grows in it, so the z that leaves less unexplained is cubed.

    Parameters
    ----------
    record : Record
    order, block_rows, band
        As `identify` takes them.
    report : callable
    relative : ndarray, shape (n,), optional
        z about the zero of the springs (m), where it was simulated; by default it is measured.

    Returns
    -------
    singular_values : ndarray
    inputs : ndarray, shape (n, 2)
    model, noise, unexplained
        As `refine_state_space` returns them.
    """
    outputs, lines = outputs_of(record), (band, record.joints)
    if relative is None:
        inputs, gram, scale = about_springs_zero(record, order, block_rows, band)
    else:
        inputs = nsi.extended_inputs(record.force, relative)
        gram, scale = scaled_gram(np.column_stack([inputs, outputs]), record.joints, block_rows)
    report(2)
    A, C, singular_values = dynamics(gram, scale, 2, order)
    report(3)
    measured = _refined(fit_to_lines(A, C, inputs, outputs, record.sample_rate, *lines), inputs, outputs, *lines)
    report(4)
    if relative is not None or len(record.joints) > 1:
        return singular_values, inputs, *measured
    model = fit_input_matrices(measured[0].A, measured[0].C, inputs, outputs, record.sample_rate)
    modelled = layout_of(record).across(model.simulate(inputs) - model.offset)
    modelled_inputs = nsi.extended_inputs(record.force, modelled)
    modelled = _refined(model, modelled_inputs, outputs, *lines)
    if np.linalg.norm(modelled[2] / measured[2]) < np.sqrt(2):
        return singular_values, modelled_inputs, *modelled
    return singular_values, inputs, replace(measured[0], start=model.start, offset=model.offset), *measured[1:]


def displacements(record, band):
    """The record with displacements for outputs, by their lines above the lower end of a band: to start from.

    Accelerations are made relative to a base, and what jumps in them with a held force is moved to where the motion
    that it causes is, half a sample later. What is dropped below the band is motion that z^3 lacks.
    """
    if displacing(record):
        return record
    tests = []
    for test in record.tests:
        channels = {}
        for name, power in zip(test.kinds, powers_of(test), strict=True):
            values, n = getattr(test, name), test.force.size
            s = 2j * np.pi * np.fft.rfftfreq(n, 1 / test.sample_rate)
            lines = np.fft.rfft(values - test.force if test.base and power == 2 else values)
            if power == 2 and test.hold == "zero" and not test.base:
                jumps = np.diff(test.force)
                lines += (
                    np.diff(values)
                    @ jumps
                    / (jumps @ jumps)
                    * np.expm1(-s / test.sample_rate / 2)
                    * np.fft.rfft(test.force)
                )
            lines[np.abs(s) < 2 * np.pi * band[0]] = 0.0
            channels[name] = np.fft.irfft(lines / np.where(s == 0, 1.0, s) ** power, n)
        tests.append(test.replace(kinds=None, **channels))
    return record.joined(tests)


def scaled_gram(channels, joints, block_rows):
    """Extended Gram matrix of all tests, and the deviations that the channels were divided by."""
    scale = channels.std(axis=0)
    scaled = (channels - channels.mean(axis=0)) / scale
    return sum(extended_gram(scaled[test], 2 * block_rows) for test in slices(joints, len(channels))), scale


def about_springs_zero(record, order, block_rows, band):
    """Inputs [f, -z^3], with a measured z about the springs' zero, the Gram matrix of them and the outputs, and scales.

    Of shapes (n, 2), (2 block_rows c, 2 block_rows c) and (c,), c channels, which were divided by the last;
    ``order`` is that of the model that tells the zero.
    """
    outputs, layout = outputs_of(record), layout_of(record)
    relative = layout.across(outputs)
    w = relative - relative.mean()
    # About the mean -z^3 is a sum of these columns and constants, so one Gram matrix serves any zero of the springs.
    channels = np.column_stack([nsi.extended_inputs(record.force, w), w**2, outputs])
    gram, deviation = scaled_gram(channels, record.joints, block_rows)
    e = _springs_zero(record, channels, gram, deviation, order, block_rows, band)
    inputs = nsi.extended_inputs(record.force, w - e)
    c = channels.shape[1]
    mixed = np.delete(np.eye(c), 2, axis=0)
    mixed[1, 2], mixed[1, 3:] = 3 * e, -3 * e**2 * layout.terms[-1].direction(c - 3)
    scale = np.concatenate([inputs.std(axis=0), deviation[3:]])
    mixed *= deviation / scale[:, None]
    gram = (mixed @ (gram.reshape(-1, c, len(gram)).transpose(1, 0, 2).reshape(c, -1))).reshape(c - 1, -1, len(gram))
    gram = gram.transpose(1, 0, 2).reshape(-1, 2 * block_rows, c) @ mixed.T
    return inputs, gram.reshape(len(gram), -1), scale


def _springs_zero(record, channels, gram, deviation, order, block_rows, band):
    """Reading of z, about its mean, at which the springs' cubic force is zero: an offset of the sensors.

    With w about the mean and z = w - e, -z^3 = -w^3 + 3 e w^2 - 3 e^2 w + e^3. The last two are a stiffness and a
    constant, so [f, -w^3, w^2] are inputs of an exact linear model, whose last column is 3 e times the second.
    ``gram`` is that of the ``channels`` (n, c), these inputs and the outputs, over their ``deviation``.
    """
    inputs, outputs = channels[:, :3], channels[:, 3:]
    rows = channels.shape[1] * 2 * max(block_rows // 2, order)  # the model is refined below: half the block rows do
    A, C, _ = dynamics(gram[:rows, :rows], deviation, 3, order)
    lines = band, record.joints
    model = fit_to_lines(A, C, inputs, outputs, record.sample_rate, *lines)
    model, noise, _ = refine_state_space(model, inputs, outputs, *lines)
    frequency = frequencies(band, record.sample_rate)
    response = nsi.extended_receptance(model, frequency, record.hold, "none") / noise[:, None]
    cube, square = response[..., 1], response[..., 2]
    offset = np.vdot(cube, square).real / np.vdot(cube, cube).real / 3
    size = np.std(layout_of(record).across(outputs))
    return np.clip(offset, -size, size)  # without a cubic force any offset would do


def _refined(model, inputs, outputs, band, joints):
    """`refine_state_space`, with the noise and the share that the refined model leaves."""
    model, *_ = refine_state_space(model, inputs, outputs, band, joints)
    return refine_state_space(model, inputs, outputs, band, joints)
