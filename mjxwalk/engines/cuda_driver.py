"""An NVIDIA GPU through its driver's C interface: memory, and kernels from PTX.

NVIDIA, "CUDA Driver API", https://docs.nvidia.com/cuda/cuda-driver-api. A function's name ends in
`_v2` where the C header renames it to that.
"""

import ctypes
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from numpy.typing import NDArray

LIBRARY = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
# Numbers of the header's enumerations.
REGISTERS, LOCAL_BYTES = 4, 3  # CUfunction_attribute
MAJOR, MINOR, MULTIPROCESSORS = 75, 76, 16  # CUdevice_attribute
ERROR_LOG, ERROR_LOG_SIZE = 5, 6  # CUjit_option
LOG_BYTES = 8_192


class CudaError(RuntimeError):
    """The driver is missing, has no GPU, or refused a call."""


class Device:
    """The first GPU, with the context that JAX has on it too.

    Attributes:
      name: as its maker calls it.
      capability: of its processors, such as "9.0".
      multiprocessors: how many it has.
    """

    def __init__(self, library: Any = None) -> None:
        """Opens the GPU.

        Args:
          library: has the driver's functions; None for the one that is installed.

        Raises:
          CudaError: there is no driver or no GPU.
        """
        self._library = _installed() if library is None else library
        self.call("cuInit", ctypes.c_uint(0))
        device, self._context = ctypes.c_int(), ctypes.c_void_p()
        self.call("cuDeviceGet", ctypes.byref(device), ctypes.c_int(0))
        self.call("cuDevicePrimaryCtxRetain", ctypes.byref(self._context), device)
        self.call("cuCtxSetCurrent", self._context)
        name = ctypes.create_string_buffer(256)
        self.call("cuDeviceGetName", name, ctypes.c_int(len(name)), device)
        self.name = name.value.decode(errors="replace")
        major, minor, self.multiprocessors = (
            self._attribute("cuDeviceGetAttribute", number, device)
            for number in (MAJOR, MINOR, MULTIPROCESSORS)
        )
        self.capability = f"{major}.{minor}"

    def call(self, function: str, *args: Any) -> None:
        """Calls a function of the driver.

        Raises:
          CudaError: it returns anything but success.
        """
        code = int(getattr(self._library, function)(*args))
        if code:
            text = ctypes.c_char_p()
            self._library.cuGetErrorString(ctypes.c_int(code), ctypes.byref(text))
            said = (text.value or b"an error without a text").decode(errors="replace")
            raise CudaError(f"{function} of the CUDA driver says: {said} (error {code})")

    def load(self, ptx: str, entry: str) -> "Kernel":
        """Returns a kernel, compiled by the driver for this GPU.

        Raises:
          CudaError: the driver does not take the PTX; its log is in the message.
        """
        self.call("cuCtxSetCurrent", self._context)
        log = ctypes.create_string_buffer(LOG_BYTES)
        options = (ctypes.c_int * 2)(ERROR_LOG, ERROR_LOG_SIZE)
        values = (ctypes.c_void_p * 2)(ctypes.addressof(log), LOG_BYTES)
        module, function = ctypes.c_void_p(), ctypes.c_void_p()
        image = ctypes.c_char_p(ptx.encode())
        number = ctypes.c_uint(len(options))
        try:
            self.call("cuModuleLoadDataEx", ctypes.byref(module), image, number, options, values)
        except CudaError as error:
            raise CudaError(f"{error}\n{log.value.decode(errors='replace')}".strip()) from error
        name = ctypes.c_char_p(entry.encode())
        self.call("cuModuleGetFunction", ctypes.byref(function), module, name)
        return Kernel(self, function)

    def run(
        self,
        kernel: "Kernel",
        inputs: Sequence[NDArray[Any]],
        outputs: Sequence[NDArray[Any]],
        count: int,
        threads: int,
    ) -> float:
        """Runs a kernel with a thread for each walker; returns what it took on the GPU, s.

        Args:
          kernel: its parameters are a pointer to each array, and the count.
          inputs, outputs: contiguous arrays in the host's memory; the outputs are written.
          count: of walkers.
          threads: of a block.
        """
        if count == 0:
            return 0.0
        self.call("cuCtxSetCurrent", self._context)
        with ExitStack() as stack:
            places = [self._allocate(stack, array.nbytes) for array in [*inputs, *outputs]]
            for place, array in zip(places, inputs, strict=False):
                size = ctypes.c_size_t(array.nbytes)
                self.call("cuMemcpyHtoD_v2", place, ctypes.c_void_p(array.ctypes.data), size)
            seconds = kernel.launch([*places, ctypes.c_int64(count)], -(-count // threads), threads)
            for place, array in zip(places[len(inputs) :], outputs, strict=True):
                size = ctypes.c_size_t(array.nbytes)
                self.call("cuMemcpyDtoH_v2", ctypes.c_void_p(array.ctypes.data), place, size)
        return seconds

    def _allocate(self, stack: ExitStack, size: int) -> ctypes.c_uint64:
        """Returns the address of memory on the GPU that the stack gives back."""
        place = ctypes.c_uint64()
        self.call("cuMemAlloc_v2", ctypes.byref(place), ctypes.c_size_t(max(1, size)))
        stack.callback(self.call, "cuMemFree_v2", place)
        return place

    def _attribute(self, function: str, number: int, of: Any) -> int:
        found = ctypes.c_int()
        self.call(function, ctypes.byref(found), ctypes.c_int(number), of)
        return found.value

    def kernel_attribute(self, number: int, function: Any) -> int:
        """Returns a number that the driver knows of a kernel."""
        return self._attribute("cuFuncGetAttribute", number, function)


class Kernel:
    """A kernel on the GPU.

    Attributes:
      registers: of a thread.
      local_bytes: of a thread's own memory, for what has no register.
    """

    def __init__(self, device: Device, function: ctypes.c_void_p) -> None:
        self._device = device
        self._function = function
        self.registers = device.kernel_attribute(REGISTERS, function)
        self.local_bytes = device.kernel_attribute(LOCAL_BYTES, function)

    def launch(self, parameters: Sequence[Any], blocks: int, threads: int) -> float:
        """Runs blocks of threads until all have ended; returns how long it took, s."""
        pointers = (ctypes.c_void_p * len(parameters))(*map(ctypes.addressof, parameters))
        sizes = [ctypes.c_uint(number) for number in (blocks, 1, 1, threads, 1, 1)]
        no_shared_memory, no_stream, nothing_more = ctypes.c_uint(0), None, None
        start = time.perf_counter()
        self._device.call(
            "cuLaunchKernel", self._function, *sizes, no_shared_memory,
            no_stream, pointers, nothing_more,
        )  # fmt: skip
        self._device.call("cuCtxSynchronize")
        return time.perf_counter() - start


def _installed() -> Any:
    """Returns the driver's library."""
    try:
        return ctypes.CDLL(LIBRARY)
    except OSError as error:
        raise CudaError(f"there is no NVIDIA driver here: {LIBRARY} cannot be opened") from error
