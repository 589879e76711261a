"""A screen without a monitor, and what is on it: for pictures of RViz on any machine, several at once."""
import os
import shutil
import struct
import subprocess
import tempfile

HEADER = struct.Struct(">25I")  # X11/XWDFile.h


class Picture:
    """Pixels as rows of red, green, blue bytes."""

    def __init__(self, width, height, rgb):
        self.width, self.height, self.rgb = width, height, rgb

    def __eq__(self, other):
        return isinstance(other, Picture) and (self.width, self.height, self.rgb) == (other.width, other.height, other.rgb)

    def share(self, predicate, every=3):
        """Which share of the pixels has a colour that predicate(r, g, b) likes; of both ways every third is looked at."""
        liked = looked_at = 0
        for y in range(0, self.height, every):
            row = self.rgb[3 * self.width * y:3 * self.width * (y + 1)]
            for x in range(0, 3 * self.width, 3 * every):
                looked_at += 1
                liked += bool(predicate(row[x], row[x + 1], row[x + 2]))
        return liked / looked_at


class VirtualScreen:
    """An X server of its own with a free display number, ended with the `with` block. Needs the package xvfb."""

    def __init__(self, width, height):
        if shutil.which("Xvfb") is None:
            raise FileNotFoundError("Xvfb is not installed (package xvfb)")
        self._folder = tempfile.mkdtemp(prefix="virtual_screen_")
        read_end, write_end = os.pipe()
        with open(os.path.join(self._folder, "log"), "w") as log:
            self._server = subprocess.Popen(
                ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "%dx%dx24" % (width, height), "-fbdir",
                 self._folder, "-nolisten", "tcp", "-noreset",
                 "-nocursor"],
                pass_fds=[write_end], stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        os.close(write_end)
        with os.fdopen(read_end) as pipe:  # ends also when the server does
            number = pipe.readline().strip()
        if not number:
            with open(os.path.join(self._folder, "log")) as log:
                text = log.read()
            self.close()
            raise RuntimeError("Xvfb did not start: " + text)
        self.display = ":" + number

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._server.terminate()
        self._server.wait()
        shutil.rmtree(self._folder, ignore_errors=True)

    def environment(self):
        """The present environment, for programs that shall show themselves here. Drawn by the processor: the same pixels on
        every machine, and no graphics card needed."""
        return dict(os.environ, DISPLAY=self.display, LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1")

    def grab(self):
        """What is to be seen now."""
        with open(os.path.join(self._folder, "Xvfb_screen0"), "rb") as file:
            data = file.read()
        fields = HEADER.unpack_from(data)
        header_size, width, height = fields[0], fields[4], fields[5]
        little_endian, bits, line, colors = fields[7] == 0, fields[11], fields[12], fields[19]
        if bits != 32:
            raise RuntimeError("Xvfb keeps %d bits for a pixel, expected 32" % bits)
        start = header_size + 12 * colors
        pixels = bytearray(3 * width * height)
        red, green, blue = (2, 1, 0) if little_endian else (1, 2, 3)
        for y in range(height):
            row = data[start + line * y:start + line * y + 4 * width]
            target = slice(3 * width * y, 3 * width * (y + 1))
            triple = bytearray(3 * width)
            triple[0::3], triple[1::3], triple[2::3] = row[red::4], row[green::4], row[blue::4]
            pixels[target] = triple
        return Picture(width, height, bytes(pixels))
