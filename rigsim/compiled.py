"""Machine code that is never older than the code it came from, made by numba when it is first called.

`compiled` marks functions for numba without importing it. Their machine code is kept on disk under a digest of all
that numba built into it: the bytecode of the function and of every function it reaches, with the values of the names
they use, as they are in this process. So an edit anywhere leads to other files, and nothing stale can be loaded.
`inlinable` marks functions of scalars that run as plain Python where Python calls them, and as machine code inside
`compiled` ones.

Standard library only until something is compiled or loaded.
"""

import _signal  # what signal makes enumerations of, which would cost each compiled call 10 us
import dis
import functools
import hashlib
import os
import pickle
import signal
import sys
import tempfile
import threading
import types
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_AGAIN = 0.05  # s until Ctrl-C is tried again
# Where Ctrl-C would leave half a library behind, or be dropped.
_CLOSED = (
    "BaseNativeLowering.run_pass", "NoPythonBackend.run_pass", "_Cache.load_overload", "_Cache.save_overload",
    "_on_type_disposal",
)  # fmt: skip
_DIGEST = hashlib.sha256().digest_size
_SIGINT = int(signal.SIGINT)
_MAIN = threading.main_thread().ident
_lock = threading.RLock()
_waiting = []  # inlinable functions that numba has not been told of


def compiled(function=None, **options):
    """Have numba compile a function when it is first called; a decorator, with or without ``options``.

    Parameters
    ----------
    function : function
        Of a module of rigsim.
    **options
        Of `numba.njit`, but for ``cache`` and ``inline``: calls between compiled functions are inlined by LLVM.

    Returns
    -------
    Compiled
    """
    return functools.partial(compiled, **options) if function is None else Compiled(function, options)


def inlinable(function):
    """Let compiled functions call a function of scalars, which stays as it is for Python; a decorator."""
    with _lock:
        _waiting.append(function)
    return function


class Compiled:
    """A function that numba compiles, or loads from disk, when it is first called.

    Attributes
    ----------
    py_func : function
        What was written.
    """

    def __init__(self, function, options):
        functools.update_wrapper(self, function)
        self.py_func = function
        self._options = options
        self._dispatcher = None

    def __call__(self, *arguments):
        """Run the machine code for arguments of these types."""
        dispatcher = self._dispatcher or self._load()
        if threading.get_ident() != _MAIN or not callable(usual := _signal.getsignal(_SIGINT)):
            return dispatcher(*arguments)
        _signal.signal(_SIGINT, functools.partial(_once_outside, usual))
        try:
            return dispatcher(*arguments)
        finally:
            _signal.signal(_SIGINT, usual)

    def _load(self):
        with _lock:
            if self._dispatcher is None:
                while _waiting:
                    function = _waiting.pop()
                    function.dispatcher = _dispatcher(function, {"forceinline": True})  # kept, as numba's type does not
                    function._numba_type_ = function.dispatcher._numba_type_
                self._dispatcher = _dispatcher(self.py_func, self._options)
        return self._dispatcher

    @property
    def _numba_type_(self):  # by which numba knows what other compiled functions may call
        return self._load()._numba_type_

    def __reduce__(self):
        return self.__qualname__  # pickled by name, as functions are


def _once_outside(usual, number, frame):
    """Handle Ctrl-C as usual, or a little later while numba is at work, which then crashes or loses it.

    That is while LLVM has half of a library, and in Python code that numba calls to wrap arguments and results.
    """
    here, compiling = frame, False
    while here is not None and here.f_code is not Compiled.__call__.__code__:
        compiling = compiling or here.f_code.co_name == "_compile_for_args"
        if "llvmlite" in here.f_code.co_filename or here.f_code.co_qualname in _CLOSED:
            break
        here = here.f_back
    if here is None or here is frame or (compiling and here.f_code is Compiled.__call__.__code__):
        signal.signal(number, usual)  # since what it raises may come before the call's own end does that
        usual(number, frame)
    else:
        again = threading.Timer(_AGAIN, signal.raise_signal, [number])
        again.daemon = True
        again.start()


def _dispatcher(function, options):
    import numba

    dispatcher = numba.njit(**options)(function)
    dispatcher._cache = _Cache(function, options)
    template = dispatcher.get_call_template

    def for_any_value(arguments, named):
        """Numba would compile again for each literal number that compiled code hands over."""
        plain = numba.types.unliteral
        return template(tuple(map(plain, arguments)), {name: plain(value) for name, value in named.items()})

    dispatcher.get_call_template = for_any_value
    return dispatcher


class _Cache:
    """What a numba dispatcher asks for machine code before it compiles, and gives it to afterwards.

    One file a function and signature, written whole or not at all, named function-stamp-signature.
    """

    cache_path = None

    def __init__(self, function, options):
        module = function.__module__.partition(".")[2] or function.__module__
        self._name = f"{module}.{function.__qualname__}"
        self._function, self._options = function, options

    @functools.cached_property
    def _stamp(self):
        import numba
        import numpy

        digest = hashlib.sha256(f"{sys.version} {numba.__version__} {numpy.__version__} {self._options}".encode())
        digest.update(Path(__file__).read_bytes())  # how functions are inlined, too
        _feed(digest, self._function, {})
        return digest.hexdigest()[:16]

    def _path(self, signature, codegen):
        text = f"{signature} {codegen.magic_tuple()}"  # the machine's kind, too
        return _folder() / f"{self._name}-{self._stamp}-{hashlib.sha256(text.encode()).hexdigest()[:16]}"

    def load_overload(self, signature, target):
        """The result of an earlier compilation, or None."""
        from numba.core.compiler import CompileResult

        target.refresh()
        try:
            kept = self._path(signature, target.codegen()).read_bytes()
        except OSError:
            kept = b""
        digest, data = kept[:_DIGEST], kept[_DIGEST:]
        if digest != hashlib.sha256(data).digest():  # there is none yet, or it is damaged
            _say_once()
            return None
        parts = pickle.loads(data)
        return CompileResult._rebuild(target, *parts)

    def save_overload(self, signature, result):
        """Keep a compilation's result, and drop those of other code by the same name."""
        from numba.core.serialize import dumps

        # An argument that is a compiled function has no name that means the same in another process.
        if result.library.has_dynamic_globals or "CPUDispatcher" in str(signature):
            return
        path = self._path(signature, result.codegen)
        data = dumps(result._reduce())
        try:
            handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".")
            with os.fdopen(handle, "wb") as file:
                file.write(hashlib.sha256(data).digest() + data)
            os.replace(temporary, path)
            _sweep(path.parent)
            for other in path.parent.glob(f"{self._name}-*"):
                if not other.name.startswith(f"{self._name}-{self._stamp}-"):
                    other.unlink(missing_ok=True)
        except OSError:
            pass  # nothing is kept, as _say_once has said


@functools.cache
def _folder():
    """Where machine code is kept: $NUMBA_CACHE_DIR if set, else beside the package, else in the user's cache."""
    place = hashlib.sha256(str(_PACKAGE).encode()).hexdigest()[:16]
    user = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folders = [_PACKAGE / "__pycache__" / "compiled", Path(user, "rigsim", place)]
    if os.environ.get("NUMBA_CACHE_DIR"):
        folders.insert(0, Path(os.environ["NUMBA_CACHE_DIR"], f"rigsim-{place}"))
    for folder in folders:
        if _writable(folder):
            return folder
    return folders[0]


def _writable(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


@functools.cache
def _say_once():
    kept = "then kept" if _writable(_folder()) else f"every time, since {_folder()} cannot be written"
    print(f"rigsim: compiling, as a first use does: half a minute at most, {kept}", file=sys.stderr, flush=True)


@functools.cache
def _sweep(folder):
    """Drop machine code of functions that are no more, and what earlier versions of rigsim kept in numba's way."""
    for path in folder.glob("[!.]*"):
        module, _, function = path.name.partition("-")[0].rpartition(".")
        source = _PACKAGE / f"{module.replace('.', '/')}.py"
        if not (source.is_file() and f"def {function}(" in source.read_text(encoding="utf-8")):
            path.unlink(missing_ok=True)
    for path in _PACKAGE.rglob("__pycache__/*.nb[ic]"):
        path.unlink(missing_ok=True)


@functools.cache
def _names(code):
    """Names of globals that a code object reads."""
    return tuple(step.argval for step in dis.get_instructions(code) if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"))


def _feed(digest, value, seen):
    """Put into the digest all of a value that compiled code depends on: of a function, also what it can reach."""
    value = getattr(value, "py_func", value)
    if isinstance(value, types.FunctionType):
        known = value in seen
        digest.update(b"function %d " % seen.setdefault(value, len(seen)))
        if known:
            return
        names = [name for code in _codes(value.__code__) for name in _names(code) if name in value.__globals__]
        cells = tuple(cell.cell_contents for cell in value.__closure__ or ())
        _feed(digest, (value.__code__, value.__defaults__, cells), seen)
        for name in names:
            found = value.__globals__[name]
            if isinstance(found, types.ModuleType) and _top(found.__name__) == _top(value.__module__):
                used = [name for code in _codes(value.__code__) for name in code.co_names if hasattr(found, name)]
                _feed(digest, tuple(getattr(found, name) for name in used), seen)
            else:
                _feed(digest, found, seen)
    elif isinstance(value, types.CodeType):
        _feed(digest, (value.co_code, value.co_names, value.co_varnames, value.co_freevars, value.co_consts), seen)
    elif isinstance(value, tuple):
        digest.update(b"tuple %d " % len(value))
        for part in value:
            _feed(digest, part, seen)
    elif isinstance(value, types.ModuleType):
        digest.update(value.__name__.encode())
    else:
        digest.update(pickle.dumps(value, protocol=4))


def _top(name):
    return name.partition(".")[0]


def _codes(code):
    """A code object and those inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)
