#!/usr/bin/env bash
# Opens the `inspector` example in a real window, picks a cloth by clicking it, drags a slider, and keeps pictures of before and after:
# docs/inspector_window.sh [FOLDER]. Needs Xvfb, xdotool and python3; says so and ends where one is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
export BEVY_ASSET_ROOT="$PWD"
out="${1:-$(mktemp -d)}"
mkdir -p "$out"
for tool in Xvfb xdotool python3; do
    command -v "$tool" >/dev/null || { echo "inspector_window: skipped, there is no $tool"; exit 0; }
done

cargo build --quiet --example inspector
program="${CARGO_TARGET_DIR:-target}/debug/examples/inspector"

display=:$((90 + RANDOM % 400))
screen="$(mktemp -d)"
Xvfb "$display" -screen 0 1280x720x24 -fbdir "$screen" >/dev/null 2>&1 &
server=$!
export DISPLAY="$display"
trap 'kill "${app:-$server}" "$server" 2>/dev/null || true' EXIT
sleep 2
"$program" >"$out/log.txt" 2>&1 &
app=$!
window=$(timeout 120 xdotool search --sync --onlyvisible --name 'bevy_drape: inspector' | head -1)
# A software driver draws a few frames per second: give it time after every step.
wait_frames() { sleep "${PAUSE:-5}"; }
xdotool windowmove "$window" 0 0
xdotool windowsize "$window" 1280 720
sleep "${START:-40}"
# The screen of Xvfb is a file in the format XWD, 32 bits per pixel, blue first.
shot() {
    python3 - "$screen/Xvfb_screen0" "$out/$1.png" <<'PYTHON'
import struct, sys, zlib
data = open(sys.argv[1], "rb").read()
head = struct.unpack(">20I", data[:80])
width, height, stride, start = head[4], head[5], head[12], head[0] + 12 * head[19]
rows = bytearray()
for y in range(height):
    line = data[start + y * stride : start + y * stride + 4 * width]
    row = bytearray(3 * width)
    row[0::3], row[1::3], row[2::3] = line[2::4], line[1::4], line[0::4]
    rows += b"\0" + row
chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
size = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
open(sys.argv[2], "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size) + chunk(b"IDAT", zlib.compress(bytes(rows), 6)) + chunk(b"IEND", b""))
PYTHON
    echo "$out/$1.png"
}

shot 1_start
# The flag, at the upper left.
xdotool mousemove 190 190; wait_frames
xdotool click 1; wait_frames
shot 2_flag_is_picked
# The first slider of the material is its density: dragged to the right.
xdotool mousemove "${SLIDER_X:-1030}" "${SLIDER_Y:-329}"; wait_frames
xdotool mousedown 1; wait_frames
for x in 5 15 25 35; do xdotool mousemove "$((${SLIDER_X:-1030} + x))" "${SLIDER_Y:-329}"; sleep 1; done
wait_frames; xdotool mouseup 1; wait_frames
shot 3_density_is_dragged
sleep 8
shot 4_heavier_flag
kill -0 "$app" && echo "the example still runs"
