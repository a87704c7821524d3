"""From the columns of a file to the channels of a record: which is which, in what unit, and how fast.

Everything that a file says is held against everything else it says and against what its reader is told; what neither
says and nothing else could be is guessed, and told by a `GuessWarning`.
"""

import reprlib
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import checks
from ..results import Result, frame
from . import clock
from .channels import HOLDS, KINDS, OUTPUTS, UNITS, checked_details, checked_kinds
from .formats import READERS, chosen
from .formats.units import SI, bare, is_unit, plain, role_of, unit_of
from .on_disk import let_go

_ROLES = (*UNITS, "time")
_QUANTITIES = {"force": ("force", "acceleration"), "tilt": ("angle",), "time": ("time",)} | dict.fromkeys(
    OUTPUTS, tuple(KINDS)
)
_SHOWN = 12  # columns in a message
EXAMPLE = 'channels={"force": ..., "shaker": ..., "mass": ...}'


class GuessWarning(UserWarning):
    """What a file does not say outright, and was taken for granted."""


@dataclass(frozen=True, eq=False, repr=False)
class FileContents(Result):
    """What a file holds, as `Record.inspect` finds it.

    Attributes
    ----------
    path, form : str
        The file, and how it is written.
    rows : tuple of tuple
        Of each column: number, name, unit, samples, sample rate (Hz), first values, what it would be read as.
    said : dict
        What the file says of all: sample rate, hold, number of samples.
    """

    path: str
    form: str
    rows: tuple
    said: dict

    def summary(self):
        """One line: how many columns, in what form, and what is said of all."""
        said = ", ".join(f"{name} {value}" for name, value in self.said.items() if name != "parameters")
        return f"{self.path}: {len(self.rows)} columns, {self.form}{'; it says ' if said else ''}{said}"

    def table(self):
        """`pandas.DataFrame` with a row a column of the file, by the numbers that ``channels=`` takes."""
        names = ["column", "name", "unit", "samples", "sample_rate", "first values", "read as"]
        return frame(self.rows, names, index="column")


@contextmanager
def _looked(path):
    path = Path(checks.path("path", path))
    with chosen(path, READERS)(path) as contents:
        yield path, contents


def inspected(path):
    """See `Record.inspect`."""
    with _looked(path) as (path, contents):
        rows, told = [], {}
        for index, column in enumerate(contents.columns):
            role, _ = role_of(plain(column.name))
            told.setdefault(role, []).append(index)
        counted = contents.count() if contents.count else None
        for index, column in enumerate(contents.columns):
            role, unit = role_of(plain(column.name))[0], bare(column.name)[1]
            meant = role if role and len(told[role]) == 1 else f"{role}?" if role else "-"
            rate = 1 / column.interval if column.interval else None
            samples = counted if column.samples is None else column.samples
            first = ", ".join(str(value)[:12] for value in column.first[:3])
            rows.append((index, column.name, column.unit or unit, samples, rate, first, column.why or meant))
        return FileContents(str(path), contents.form, tuple(rows), dict(contents.details))


def fields_of(path, hold=None, channels=None, units=None, sample_rate=None):
    """Arguments of `Record` from a file; see `Record.load`."""
    hold = None if hold is None else checks.one_of("hold", hold, HOLDS)
    units = _asked("units", units, _ROLES, str, "mm")
    channels = _asked("channels", channels, _ROLES, (str, int, np.integer), "Ch1 [N]")
    if sample_rate is not None:
        sample_rate = checks.positive("sample_rate", sample_rate, "Hz")
    with _looked(path) as (path, contents):
        details, notes = checked_details(path, contents.details), list(contents.notes)
        kinds = details.get("kinds")
        one_sensor = "mass" not in channels if channels else isinstance(kinds, dict) and "mass" not in kinds
        found = _columns(path, contents, channels, one_sensor, notes)
        scales, assumed, said_kinds = _scales(path, contents, details, found, units, notes)
        intervals = sorted({contents.columns[index].interval for index in found.values()} - {None})
        names, sizes = {index: name for name, index in found.items()}, {}

        def used(index, one):
            """A channel in SI; the instants are held against all else and then gone, which a long record needs."""
            name, place = names[index], lambda sample: contents.place(index, sample)
            sizes[name] = one.size
            if scales[name] != 1.0:
                one *= scales[name]
            _finite(path, name, one, place)
            let_go(one)
            if name != "time":
                return one
            if one.size == details.get("samples", one.size):
                told = details, intervals, sample_rate, one, notes
                details["sample_rate"] = clock.rate(path, *told, assumed="time" in assumed, place=place)
            return None

        values = dict(zip(found, contents.values(list(found.values()), used), strict=True))
    count = details.pop("samples", sizes["force"])
    for name, size in sizes.items():
        if size != count:
            told = "as the file or its force says"
            raise ValueError(f"{name} in {path} has {size} samples; expected {count}, {told}")
    if "time" not in found:
        details["sample_rate"] = clock.rate(path, details, intervals, sample_rate, None, notes)
    values.pop("time", None)
    details["hold"] = _hold(path, details.get("hold"), hold)
    details["kinds"] = said_kinds
    for one in values.values():
        one.flags.writeable = False  # so a record need not copy it
    if notes:
        warnings.warn(f"{path.name}: read {'; '.join(notes)} (guessed)", GuessWarning, stacklevel=3)
    return {"mass": None} | values | details


def _asked(name, given, keys, kinds, example):
    """A dict that a reader is given, checked."""
    if given is None:
        return {}
    if not isinstance(given, dict):
        raise ValueError(
            f'{name} = {checks.shown(given)} is not allowed; expected a dict such as {{"shaker": "{example}"}}'
        )
    given = {checks.one_of(f"channel of {name}", key, keys): value for key, value in given.items()}
    for key, value in given.items():
        if not isinstance(value, kinds) or isinstance(value, bool):
            told = f'{name}["{key}"] = {checks.shown(value)}'
            raise ValueError(
                f"{told} is not allowed; expected a text{'' if kinds is str else ' or the number of a column'}"
            )
    return given


def _columns(path, contents, channels, one_sensor, notes):
    """Which column is which channel: a dict of numbers."""
    names = [column.name for column in contents.columns]
    found = {role: _named(path, names, role, wanted) for role, wanted in channels.items()}
    needed = [role for role in ("force", "shaker", "mass") if not (role == "mass" and one_sensor)]
    for role in [*needed, "time", "tilt", *(["voltage"] if contents.own else [])]:
        if role in found or (channels and role in ("tilt", "voltage")):
            continue
        index = _only(path, contents, names, role)
        if index is not None:
            found[role] = index
    missing = [role for role in needed if role not in found]
    if missing:
        held = ", ".join(
            f"{index}: {reprlib.repr(name) if name else 'unnamed'}" for index, name in enumerate(names[:_SHOWN])
        )
        more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
        fewer = ", without mass for one sensor" if missing[0] == "mass" else ""
        told = f"{path} has no channel {missing[0]} by that name; it holds {held}{more}"
        raise ValueError(f"{told}; expected {EXAMPLE}{fewer}")
    for role, index in found.items():
        others = [other for other in found if found[other] == index and other != role]
        if others:
            raise ValueError(f"channels give column {names[index]!r} as {role} and {others[0]}; expected one each")
        if contents.columns[index].why:
            raise ValueError(f"{path} cannot be read as a record: {contents.columns[index].why}")
    changed = [
        f"{reprlib.repr(names[i])} as {role}" for role, i in found.items() if role not in channels and names[i] != role
    ]
    unused = [reprlib.repr(name) for index, name in enumerate(names) if index not in found.values() and name]
    if changed:
        notes.append(", ".join(changed))
    if unused and not channels:
        notes.append(f"without {', '.join(unused[:_SHOWN])}")
    return found


def _only(path, contents, names, role):
    """Number of the one column that must be a channel, None where there is none."""
    meant = _meant(names, role)
    if role == "time":
        first = {index: contents.columns[index].first for index in meant}
        # Of a column without instants nothing is learnt; of several those of the clock rather than of the day.
        meant = [index for index in meant if any(first[index]) or not first[index]]
        meant = [index for index in meant if "date" not in names[index].lower()][:1] or meant[:1]
    if len(meant) > 1:
        several = ", ".join(reprlib.repr(names[index]) for index in meant[:_SHOWN])
        raise ValueError(
            f"{path} names the channel {role} {len(meant)} times ({several}); expected channels= to say which"
        )
    return meant[0] if meant else None


def _named(path, names, role, wanted):
    """Number of the column that a reader asks for."""
    if not isinstance(wanted, str):
        if not 0 <= wanted < len(names):
            told = f"channels[{role!r}] = {wanted}"
            raise ValueError(f"{told} is not allowed; expected a column of {path} from 0 to {len(names) - 1}")
        return int(wanted)
    word = wanted.strip().casefold()
    for same in (
        lambda name: name == wanted, lambda name: name.strip().casefold() == word,
        lambda name: bare(name)[0].casefold() == word,
        lambda name: plain(name).casefold() == word,
    ):  # fmt: skip
        matches = [index for index, name in enumerate(names) if same(name)]
        if len(matches) == 1:
            return matches[0]
        if matches:
            numbers = ", ".join(map(str, matches))
            raise ValueError(
                f"{path} names {wanted!r} {len(matches)} times; expected the number of a column, {numbers}"
            )
    held = ", ".join(map(reprlib.repr, names[:_SHOWN]))
    raise ValueError(f"channels[{role!r}] = {wanted!r} is not in {path}; expected one of {held}")


def _meant(names, role):
    """Columns that a role's name is exactly, or else can only mean."""
    exact = [index for index, name in enumerate(names) if name == role]
    if exact:
        return exact
    found = [index for index, name in enumerate(names) if role_of(plain(name))[0] == role]
    if role == "time" and not found:
        found = [index for index, name in enumerate(names) if (unit_of(bare(name)[1] or "-") or "-")[0] == "time"]
    return found


def _scales(path, contents, details, found, units, notes):
    """Factors to SI by channel, those whose unit is assumed, and the kind of each output."""
    told = details.pop("units", None) or {}
    if not isinstance(told, dict):
        raise ValueError(
            f"units in {path} = {checks.shown(told)} is not allowed; expected a dict such as {{'mass': 'mm'}}"
        )
    kinds = details.pop("kinds", None)
    kinds = checked_kinds(kinds) if kinds is not None else {}
    scales, assumed, said = {}, [], {}
    for role, index in found.items():
        column = contents.columns[index]
        unit = bare(column.name)[1]
        _, word = role_of(plain(column.name))
        kind = kinds.get(role) or (word if role in OUTPUTS else "")
        kind = "acceleration" if role == "force" and details.get("base") else kind
        quantities = (kind,) if kind else _QUANTITIES.get(role, ())
        sources = {f"{path}": column.unit, f"the name {column.name!r}": unit, "the first line": told.get(role, ""),
                   "units=": units.get(role, "")}  # fmt: skip
        if role == "time" and index in contents.stamps:
            sources = {"dates": "s"}
        if role == "voltage":  # volts are what no other channel of a record has
            _volts(path, sources)
            scales[role] = 1.0
            continue
        unit, (quantity, factor) = _one_unit(path, role, sources, quantities)
        if not unit:
            quantity, factor = quantities[0], 1.0
            assumed.append(role)
        scales[role] = factor
        if role in OUTPUTS:
            said[role] = quantity
        elif quantity == "acceleration" and not details.get("base"):
            details["base"] = True
            notes.append("the force as the acceleration of a base, by its unit")
        if role in OUTPUTS and quantity != "displacement" and not kinds:
            notes.append(f"{role} as {quantity}, by its {'unit ' + unit if unit else 'name'}")
    taken = [f"{role} in {SI[said.get(role, _QUANTITIES[role][0])]}" for role in assumed if role != "time"]
    if taken and not contents.own:
        notes.append(", ".join(taken))
    return scales, assumed, said


def _volts(path, sources):
    """Refuse a voltage in another unit."""
    for unit in sources.values():
        if unit not in ("", "V"):
            raise ValueError(f"unit of voltage in {path} = {checks.shown(unit)} is not allowed; expected V")


def _one_unit(path, role, sources, quantities):
    """The unit that all who say one agree on, its quantity and factor; "" where nobody says one."""
    found = None
    expected = ", ".join(SI[quantity] for quantity in quantities)
    for who, unit in sources.items():
        if not str(unit).strip():
            continue
        known = unit_of(str(unit))
        if known is None and who != "units=" and unit_of(sources.get("units=", "")):
            continue  # what a reader says in its place is taken
        if known is None or known[0] not in quantities:
            told = f"unit of {role} in {path} = {checks.shown(unit)}"
            hint = "" if is_unit(str(unit)) and known else f', or units={{"{role}": ...}}'
            raise ValueError(f"{told} is not allowed; expected {expected} or a multiple of it{hint}")
        if found and found[1] != known:
            raise ValueError(f"unit of {role} in {path} = {found[0]!r}, but {who} says {unit!r}; expected one")
        found = found or (unit, known)
    return found or ("", ("", 1.0))


def _finite(path, name, values, place):
    """Refuse what is missing, with its place."""
    if np.isfinite(values).all():
        return
    sample = int(np.argmin(np.isfinite(values)))
    unit = UNITS.get(name, "s")
    raise ValueError(
        f"{path}: {name}[{sample}] = {values[sample]} {unit} is not allowed; expected a finite number ({place(sample)})"
    )


def _hold(path, said, asked):
    """What the force did between samples: the file or the reader says it."""
    if asked is not None and said is not None and said != asked:
        raise ValueError(f"hold = {asked!r} is not allowed; {path} says {said!r}")
    if said is None and asked is None:
        raise ValueError(
            f"{path} does not say what the force did between samples; expected hold in its first line or as an "
            f"argument, one of {', '.join(map(repr, HOLDS))}"
        )
    return said if said is not None else asked
