#!/usr/bin/env python3
"""Plays a clip from servers that give ranges, give them slowly or not at all, break off, or answer wrongly:
`kinora play http://…` on a display of its own (Xvfb).

usage: address_check.py KINORA SAMPLE    SAMPLE: a capture of which a small clip is made
"""
import contextlib
import http.server
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time

from window_check import Player, Screen, expect, pixels

FRAMES = 4
PIECE = 25000  # bytes that a slow server gives in 20 ms, which is 10 Mbit/s


class Faulty(http.server.BaseHTTPRequestHandler):
    """One way of answering for each path."""
    protocol_version = "HTTP/1.1"
    clip = b""
    asked = {}

    def log_message(self, *_):
        pass

    def do_GET(self):
        mode = self.path.split("/")[1]
        count = Faulty.asked[mode] = Faulty.asked.get(mode, 0) + 1
        first, last = map(int, re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers["Range"]).groups())
        body = self.clip[first:last + 1]
        if mode == "absent" or (mode == "vanishing" and first > 0):
            self.answer(404, b"none")
        elif mode == "failing" or (mode == "recovering" and count % 2):
            self.answer(503, b"busy")
        elif mode == "whole":
            self.answer(200, self.clip)
        elif mode == "elsewhere" and first > 0:
            self.answer(206, body, first + 1)
        elif mode == "changing":
            self.answer(206, body, first, tag=str(count))
        elif mode == "slow":
            self.answer(206, body, first, pause=0.02)
        elif mode == "breaking" and len(body) > 20000:
            self.answer(206, body[:20000], first, length=len(body))
            self.close_connection = True
        else:
            self.answer(206, body, first)

    def answer(self, status, body, first=0, length=None, tag="one", pause=0.0):
        self.send_response(status)
        self.send_header("Content-Length", str(len(body) if length is None else length))
        self.send_header("ETag", tag)
        if status == 206:
            self.send_header("Content-Range", f"bytes {first}-{first + len(body) - 1}/{len(self.clip)}")
        self.end_headers()
        with contextlib.suppress(ConnectionError):  # a player that refuses the answer hangs up
            for start in range(0, len(body), PIECE):
                self.wfile.write(body[start:start + PIECE])
                time.sleep(pause)


def shows(kinora, clip, screen, folder, wanted):
    """Whether its first frame comes to look as it should; while the clip is on its way, less is shown."""
    folder.mkdir()
    player = Player([kinora, "play", clip], screen, folder)
    try:
        player.do("key", "comma", "Left", "Left", "Left")
        shown = player.comes_to_show(wanted)
        player.do("key", "q")
        expect(player.process.wait(timeout=60) == 0, "the key q did not end it well")
    finally:
        player.process.kill()
    return shown


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    kinora, sample = map(os.path.abspath, sys.argv[1:3])
    with tempfile.TemporaryDirectory() as name, Screen() as screen:
        folder = pathlib.Path(name)
        clip = folder / "clip.mkv"
        words = [kinora, "encode", sample, clip, "--preset", "fast", "--frames", f"0:{FRAMES}", "--quiet"]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        Faulty.clip = clip.read_bytes()
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Faulty)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}"
        drawn = folder / "drawn.png"
        subprocess.run([kinora, "render", clip, drawn, "--size", "960x720", "--frames", "0", "--quiet"], check=True,
                       stdout=subprocess.DEVNULL)
        wanted = pixels(drawn)
        for mode in ("good", "slow", "whole", "recovering", "breaking"):
            expect(shows(kinora, f"{address}/{mode}/clip.mkv", screen, folder / mode, lambda picture: picture == wanted),
                   f"from the server that is {mode} the picture is another")
        environment = {**os.environ, "DISPLAY": screen.name}
        for mode in ("vanishing", "elsewhere"):  # what came before the fault stays to be seen
            expect(shows(kinora, f"{address}/{mode}/clip.mkv", screen, folder / mode, lambda picture: max(picture[::4]) > 100),
                   f"from the server that is {mode} nothing is seen")
        for mode, status, words in (("absent", 3, "no such file"), ("failing", 1, "status 503"), ("changing", 4, "was changed")):
            ended = subprocess.run([kinora, "play", f"{address}/{mode}/clip.mkv"], capture_output=True, text=True,
                                   check=False, env=environment, timeout=60)
            expect(ended.returncode == status and words in ended.stderr and ended.stderr.count("\n") == 1,
                   f"{mode}: {ended.returncode}, {ended.stderr}")
        server.shutdown()
        ended = subprocess.run([kinora, "play", "http://127.0.0.1:1/clip.mkv"], capture_output=True, text=True, check=False,
                               env=environment, timeout=60)
        expect(ended.returncode == 1 and "cannot be reached" in ended.stderr, ended.stderr)


if __name__ == "__main__":
    main()
