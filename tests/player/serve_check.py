#!/usr/bin/env python3
"""Runs `kinora serve` on a folder, asks it as players, browsers and intruders do, and ends it with Ctrl-C.

usage: serve_check.py KINORA
"""
import http.client
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import urllib.parse

CLIP = bytes(range(256)) * 1000


def expect(true, sentence):
    if not true:
        sys.exit(sentence)


def ask(address, path, method="GET", **headers):
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=20)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer, body


def check_ranges(address):
    answer, body = ask(address, "/clip.mkv")
    expect(answer.status == 200 and body == CLIP, "the whole file is not what was asked for")
    expect(answer.getheader("Accept-Ranges") == "bytes" and answer.getheader("ETag"), str(answer.getheaders()))
    for name, wanted in {"Access-Control-Allow-Origin": "*", "Cross-Origin-Opener-Policy": "same-origin",
                         "Cross-Origin-Embedder-Policy": "require-corp"}.items():
        expect(answer.getheader(name) == wanted, f"{name} is {answer.getheader(name)}")
    for asked, first, end in (("0-9", 0, 10), ("70000-199999", 70000, 200000), ("255990-", 255990, 256000), ("-5", 255995, 256000),
                              ("255990-999999", 255990, 256000), ("-999999", 0, 256000)):
        answer, body = ask(address, "/clip.mkv", Range=f"bytes={asked}")
        expect(answer.status == 206 and body == CLIP[first:end], f"bytes={asked}: {answer.status}, {len(body)} bytes")
        expect(answer.getheader("Content-Range") == f"bytes {first}-{end - 1}/256000", str(answer.getheaders()))
    answer, body = ask(address, "/clip.mkv", Range="bytes=256000-256010")
    expect(answer.status == 416 and answer.getheader("Content-Range") == "bytes */256000" and not body, f"past the end: {answer.status}")
    answer, body = ask(address, "/clip.mkv", "HEAD")
    expect(answer.status == 200 and answer.getheader("Content-Length") == "256000" and not body, "HEAD")
    answer, body = ask(address, "/empty.mkv")
    expect(answer.status == 200 and not body, "a file of no bytes")
    answer, _ = ask(address, "/clip.mkv", "OPTIONS", Origin="http://elsewhere")
    expect("Range" in answer.getheader("Access-Control-Allow-Headers", ""), "a browser may not ask for ranges")


def check_outside(address):
    for path in ("/../secret.mkv", "/%2e%2e/secret.mkv", "/..%2fsecret.mkv", "/link.mkv", "/linked/secret.mkv", "//etc/passwd",
                 "/sub/../../secret.mkv", "/.kinora/../../secret.mkv", "/.kinora/%2e%2e/%2e%2e/secret.mkv", "/none.mkv", "/sub", "/clip.mkv%00.png", "/"):
        answer, body = ask(address, path)
        expect(b"secret" not in body and b"root:" not in body, f"{path} gives what lies outside of the folder")
        expect(path == "/" or answer.status in (400, 404), f"{path}: status {answer.status}")


def check_page(address):
    answer, body = ask(address, "/")
    page = body.decode()
    expect(answer.status == 200 and "clip.mkv</a> 0.3 MB" in page, page)
    if "/.kinora/" in page:  # web/build has been run
        expect('href="/.kinora/index.html?clip=/sub/a%2520%253Cb%253E.mkv"' in page, page)
        for packed, coding in (("", None), ("gzip", "gzip"), ("gzip, deflate, br", "br")):
            answer, _ = ask(address, "/.kinora/kinora-player.js", **{"Accept-Encoding": packed})
            expect(answer.status == 200 and answer.getheader("Content-Type") == "text/javascript", str(answer.getheaders()))
            expect(answer.getheader("Content-Encoding") == coding, str(answer.getheaders()))
    expect('href="/sub/a%20%3Cb%3E.mkv"' in page and "a &#60;b&#62;.mkv" in page, page)
    expect("link.mkv" not in page, "the page lists what it does not give")
    answer, body = ask(address, "/sub/a%20%3Cb%3E.mkv")
    expect(answer.status == 200 and body == b"small", "the page's address of a clip does not lead to it")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as name:
        outside = pathlib.Path(name)
        folder = outside / "clips"
        (folder / "sub").mkdir(parents=True)
        (outside / "secret.mkv").write_bytes(b"secret")
        (folder / "clip.mkv").write_bytes(CLIP)
        (folder / "empty.mkv").write_bytes(b"")
        (folder / "sub/a <b>.mkv").write_bytes(b"small")
        (folder / "link.mkv").symlink_to(outside / "secret.mkv")
        (folder / "linked").symlink_to(outside)
        words = [sys.argv[1], "serve", str(folder), "--port", "0", "--json"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server:
            try:
                text = ""
                while "}" not in text:
                    line = server.stdout.readline()
                    expect(line, f"the server ended: {text}")
                    text += line
                address = urllib.parse.urlparse(json.loads(text)["address"])
                expect(address.hostname == "127.0.0.1", "it listens to other machines without being asked to")
                check_ranges(address)
                check_outside(address)
                check_page(address)
                taken = subprocess.run([*words[:4], str(address.port)], capture_output=True, text=True, check=False)
                expect(taken.returncode == 1 and "give another --port" in taken.stderr, taken.stderr)
                server.send_signal(signal.SIGINT)
                expect(server.wait(timeout=30) == 0, "Ctrl-C did not end it well")
            finally:
                server.kill()
        none = subprocess.run([*words[:2], os.path.join(name, "none")], capture_output=True, text=True, check=False)
        expect(none.returncode == 2 and "is no folder" in none.stderr, none.stderr)


if __name__ == "__main__":
    main()
