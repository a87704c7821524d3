"""Records to files, whole or not at all, and what their headers say of a record."""

import os
import shutil
from contextlib import suppress
from dataclasses import MISSING, asdict, fields
from pathlib import Path
from uuid import uuid4

from .. import checks, parameters
from .channels import DETAILS, checked_kinds
from .formats import WRITERS, chosen

_KINDS = {kind.__name__: kind for kind in (parameters.RigParameters, parameters.OscillatorParameters)}


def saved(record, path):
    """See `Record.save`."""
    path = Path(checks.path("path", path))
    write, units = chosen(path, WRITERS), {"time": "s"} | record.units
    written(path, lambda file: write(file, _details(record), {"time": record.time} | record.channels, units), "record")


def written(path, write, what):
    """Have ``write(file)`` make a file, whole or not at all; ``what`` it is, for a message."""
    # A link stays one: what it points to is replaced.
    target = Path(os.path.realpath(path))
    if target.exists() and not (target.is_file() and os.access(target, os.W_OK)):
        raise OSError(f"{path} cannot be replaced; expected the name of a new file, or of one that may be written")
    temporary, kept = target.with_name(f".rigsim-{uuid4().hex}"), ""
    try:
        with open(temporary, "xb") as file:
            write(file)
        if target.exists() and target.stat().st_nlink > 1:
            # Replacing it would leave the file's other names with what was; so it is written over, from a whole copy.
            kept = f"; it is whole in {temporary.name} beside it"
            _written_over(temporary, target)
            kept = ""
        elif target.exists():
            shutil.copymode(target, temporary)
        if temporary.exists():
            os.replace(temporary, target)
    except BaseException as error:
        if not kept:
            with suppress(OSError):
                temporary.unlink()
        if isinstance(error, OSError):
            reason = error.strerror or " ".join(str(error).split())
            raise OSError(error.errno, f"the {what} cannot be written: {reason}{kept}", str(path)) from None
        raise


def _written_over(source, target):
    with open(source, "rb") as new, open(target, "r+b") as file:
        shutil.copyfileobj(new, file, 1 << 20)
        file.truncate()
        file.flush()
        os.fsync(file.fileno())
    source.unlink()


def tested(path, values):
    """Parameters from their JSON object."""
    if values is None:
        return None
    kind = _KINDS[checks.one_of(f"kind of parameters in {path}", values.pop("kind", None), tuple(_KINDS))]
    known = {item.name: item for item in fields(kind)}
    values = {checks.one_of(f"parameter in {path}", name, tuple(known)): value for name, value in values.items()}
    missing = [name for name, item in known.items() if item.default is MISSING and name not in values]
    if missing:
        raise ValueError(f"parameters in {path} lack {', '.join(missing)}; expected every value of {kind.__name__}")
    try:
        return kind(**values)
    except (ValueError, TypeError, OverflowError) as error:
        raise ValueError(f"parameters in {path}: {error}") from None


def _details(record):
    """What the header of a file says, without what is unknown."""
    details = {name: getattr(record, name) for name in DETAILS} | {"samples": record.force.size}
    usual = {"kinds": checked_kinds(None), "base": False, "joints": (0,)}
    details = {name: value for name, value in details.items() if value != usual.get(name)}
    if record.parameters is not None:
        details["parameters"] = {"kind": type(record.parameters).__name__, **asdict(record.parameters)}
    return {name: value for name, value in details.items() if value is not None}
