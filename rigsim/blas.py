"""One thread for linear algebra while rigsim computes.

With several, sums are cut in other places: the last bits would follow OPENBLAS_NUM_THREADS and the number of cores.
And matrices as small as ours are slower for it where cores are busy.
"""

import functools
import threading

_lock = threading.Lock()
_inside = 0
_limits = None


def one_blas_thread(function):
    """Decorator: the process's BLAS libraries keep to one thread until the last of such calls, in any thread, ends."""

    @functools.wraps(function)
    def single(*arguments, **options):
        global _inside, _limits
        with _lock:
            if not _inside:
                _limits = _controller().limit(limits=1, user_api="blas")
            _inside += 1
        try:
            return function(*arguments, **options)
        finally:
            with _lock:
                _inside -= 1
                if not _inside:
                    _limits.restore_original_limits()

    return single


@functools.cache
def _controller():
    import numpy  # noqa: F401
    import scipy.linalg  # noqa: F401  Both bring a BLAS, which must be there to be found.
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
