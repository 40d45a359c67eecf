#!/usr/bin/env python3
"""Runs `kinora play` on a display of its own (Xvfb), with real keys and clicks, and looks at what it writes.

usage: window_check.py KINORA SAMPLE [LOOK.png]    SAMPLE: a capture of which a small clip is made; LOOK.png: the screen
"""
import array
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

FRAMES = 8
TONE = 440  # Hz
WAIT = 60  # seconds for what a slow machine does


def expect(true, sentence):
    if not true:
        sys.exit(sentence)


def until(what, sentence):
    end = time.monotonic() + WAIT
    while time.monotonic() < end:
        found = what()
        if found:
            return found
        time.sleep(0.1)
    sys.exit(sentence)


def pixels(path):
    words = ["ffmpeg", "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgba", "-"]
    return subprocess.run(words, check=True, capture_output=True).stdout


class Screen:
    """An X server without a window manager."""

    def __enter__(self):
        reading, writing = os.pipe()
        words = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1000x760x24", "-nolisten", "tcp"]
        self.server = subprocess.Popen(words, pass_fds=[writing], stderr=subprocess.DEVNULL)
        os.close(writing)
        with os.fdopen(reading) as number:
            self.name = ":" + number.readline().strip()
        expect(self.name != ":", "Xvfb did not start")
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


class Player:
    def __init__(self, words, screen, folder):
        self.heard = folder.parent / "heard.raw"
        self.environment = {**os.environ, "DISPLAY": screen.name, "LIBGL_ALWAYS_SOFTWARE": "1", "SDL_AUDIODRIVER": "disk",
                            "SDL_DISKAUDIOFILE": str(self.heard)}  # a file is the loudspeaker
        self.folder = folder
        self.process = subprocess.Popen(list(map(str, words)), cwd=folder, env=self.environment,
                                        stderr=subprocess.PIPE, text=True)
        self.window = until(self.find, "there is no window")
        self.do("windowfocus", self.window)

    def find(self):
        expect(self.process.poll() is None, f"it ended: {self.process.returncode} {self.process.stderr.read() if self.process.poll() else ''}")
        found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "Kinora"], env=self.environment, capture_output=True,
                               text=True, check=False).stdout.split()
        return found[-1] if found else None

    def do(self, *words):
        subprocess.run(["xdotool", *words], env=self.environment, check=True)
        time.sleep(0.3)

    def drag(self, start, end, button="1"):
        self.do("mousemove", *map(str, start))
        self.do("mousedown", button)
        for part in (0.25, 0.5, 0.75, 1):
            self.do("mousemove", *(str(round(a + part * (b - a))) for a, b in zip(start, end)))
        self.do("mouseup", button)

    def screenshot(self):
        """The file that the key s makes."""
        before = set(self.folder.iterdir())
        self.do("key", "s")
        new = until(lambda: set(self.folder.iterdir()) - before, "the key s makes no picture")
        time.sleep(0.2)
        expect(len(new) == 1, f"one screenshot, several files: {new}")
        return new.pop()

    def comes_to_show(self, wanted):
        """Whether a screenshot is as wanted, in the end: what is drawn while a clip is being read is less."""
        end = time.monotonic() + WAIT
        while not wanted(pixels(self.screenshot())):
            if time.monotonic() > end:
                return False
        return True


def check_playing(player, kinora, clip, look):
    player.do("key", "l")  # until something is heard, however late a busy machine gives it
    until(lambda: player.heard.exists() and any(player.heard.read_bytes()), "no sound is heard")
    player.do("key", "comma")  # it pauses
    player.do("key", "Left", "Left", "Left")  # more than the clip has: its start
    first = player.screenshot()
    expect(first.name == "clip-000000.png", f"the first frame's picture is {first.name}")
    again = player.screenshot()
    expect(again.name == "clip-000000-2.png", f"the first frame's second picture is {again.name}")
    drawn = player.folder.parent / "drawn.png"
    subprocess.run([kinora, "render", clip, drawn, "--size", "960x720", "--frames", "0", "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    home = pixels(drawn)
    expect(player.comes_to_show(lambda picture: picture == home), "a screenshot is not what kinora render draws")
    player.do("key", "period")
    player.do("key", "period")
    player.do("key", "comma")
    expect(player.screenshot().name == "clip-000001.png", "two steps on and one back do not lead to frame 1")
    player.do("mousemove", "930", "705")  # near the scrub bar's end
    player.do("click", "1")
    late = int(player.screenshot().stem.split("-")[1])
    expect(late >= FRAMES - 2, f"a click near the bar's end leads to frame {late}")
    player.do("key", "Left", "Left")
    if look:
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "x11grab", "-video_size", "1000x760", "-i",
                        player.environment["DISPLAY"], "-frames:v", "1", look], check=True)
    return home


def check_camera(player, home, kinora, clip):
    player.do("key", "r")
    player.drag((500, 350), (600, 380))
    player.do("key", "r")
    path = until(lambda: [p for p in player.folder.iterdir() if p.name == "transforms.json"], "no transforms.json")[0]
    turned = player.screenshot()
    expect(pixels(turned) != home, "a drag turns nothing")
    cameras = json.loads(path.read_text())["frames"]
    expect(len(cameras) >= 3, f"{len(cameras)} cameras were recorded")
    wanted = player.folder.parent / "turned.png"
    last = len(cameras) - 1
    subprocess.run([kinora, "render", clip, wanted, "--cameras", path, "--frames", str(last), "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    expect(pixels(turned) == pixels(wanted), "from the recorded camera kinora render draws another picture")
    player.drag((500, 350), (560, 350), "2")
    panned = pixels(player.screenshot())
    player.do("click", "4")
    expect(len({home, pixels(turned), panned, pixels(player.screenshot())}) == 4, "panning or zooming changes nothing")
    player.do("key", "Home")
    expect(pixels(player.screenshot()) == home, "Home does not lead back to the capture's view")
    player.do("key", "1")
    expect(pixels(player.screenshot()) != home, "hiding a layer changes nothing")
    player.do("key", "1")
    seen = {home}
    for key in "dnvh":
        player.do("key", key)
        seen.add(pixels(player.screenshot()))
    expect(len(seen) == 5, "the views of depth, normals, confidence and health are not five different pictures with colour")


def check_sound(player):
    """What was heard is the clip's tone, with gaps where a busy machine gave none."""
    left = array.array("f", player.heard.read_bytes())[::2]
    expect(max(left, default=0) > 0.02, "no sound was heard")
    rises = [i for i, (a, b) in enumerate(zip(left, left[1:])) if a < 0 <= b]
    heard = 48000 / statistics.median(b - a for a, b in zip(rises, rises[1:]))
    expect(abs(heard - TONE) < 10, f"a tone of {heard:.0f} Hz was heard, not of {TONE}")


def check_display_that_vanishes(kinora, clip, folder):
    """The player ends, says why in a few words, and leaves nothing half-written."""
    with Screen() as screen:
        player = Player([kinora, "play", clip], screen, folder)
        try:
            screen.server.kill()
            screen.server.wait()
            status = player.process.wait(timeout=WAIT)
            said = player.process.stderr.read()
            expect(0 < status < 128, f"without its display it ended with {status}: {said}")
            expect("display" in said.lower() or "server" in said.lower() or "X connection" in said, f"it does not say why it ended: {said}")
            expect(not list(folder.glob("*.part")), "something was left half-written")
        finally:
            player.process.kill()


def check_growing_clip(kinora, sample, screen, folder):
    """A capture that is encoded live is seen while it grows; the window stays, and may be closed."""
    clip = folder.parent / "growing.mkv"
    report = folder.parent / "report.json"
    script = folder.parent / "script.txt"
    script.write_text("stall 0.4 5\n")  # the capture is seen for some seconds, however slow the machine
    player = Player([kinora, "encode", sample, clip, "--live", "--live-script", script, "--view", "--quiet", "--report", report],
                    screen, folder)
    try:
        picture = pixels(player.screenshot())
        expect(max(picture[3::4]) == 255, "nothing is seen of a growing clip")
        growing = os.stat(clip).st_ino
        until(lambda: os.stat(clip).st_ino != growing, "no whole clip takes the growing one's place")
        player.do("key", "q")
        expect(player.process.wait(timeout=WAIT) == 0, "encoding did not end well after its window was closed")
        live = json.loads(report.read_text())["live"]
        expect(live["views_refined"] > 0, "the window's camera does not steer the training")
        subprocess.run([kinora, "validate", clip, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    finally:
        player.process.kill()


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    kinora, sample = map(os.path.abspath, sys.argv[1:3])
    with tempfile.TemporaryDirectory() as name:
        clip = pathlib.Path(name) / "clip.mkv"
        tone = pathlib.Path(name) / "tone.wav"
        subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i", f"sine={TONE}:duration=2", tone], check=True)
        subprocess.run([kinora, "encode", sample, clip, "--preset", "fast", "--frames", f"0:{FRAMES}", "--audio", tone, "--quiet"],
                       check=True, stdout=subprocess.DEVNULL)
        none = subprocess.run([kinora, "play", clip], capture_output=True, text=True, check=False,
                              env={k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")})
        expect(none.returncode == 6 and "no display" in none.stderr and none.stderr.count("\n") == 1, none.stderr)
        folder = pathlib.Path(name) / "pictures"
        folder.mkdir()
        with Screen() as screen:
            player = Player([kinora, "play", clip], screen, folder)
            try:
                home = check_playing(player, kinora, clip, sys.argv[3] if len(sys.argv) == 4 else None)
                check_camera(player, home, kinora, clip)
                player.do("key", "q")
                expect(player.process.wait(timeout=WAIT) == 0, "the key q did not end it well")
                check_sound(player)
            finally:
                player.process.kill()
            check_growing_clip(kinora, sample, screen, folder)
        check_display_that_vanishes(kinora, clip, folder)


if __name__ == "__main__":
    main()
