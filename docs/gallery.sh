#!/usr/bin/env bash
# Draws every picture in docs/gallery from runs without a window: docs/gallery.sh [NAME ...]. Look at them before you commit them.
set -euo pipefail
cd "$(dirname "$0")/.."
export BEVY_ASSET_ROOT="$PWD"
out=docs/gallery

# Name of the picture, then the example and its arguments.
pictures=(
    "hello_cloth hello_cloth --frames 240 --out"
    "flag flag --frames 240 --out"
    "drape drape --frames 240 --out"
    "net net --frames 300 --out"
    "grab grab --frames 98 --out"
    "gltf gltf --frames 84 --out"
    "stack stack --frames 120 --out"
    "curtain curtain --frames 100 --out"
    "skirt skirt --frames 160 --out"
    "twist twist --frames 150 --out"
    "funnel funnel --frames 70 --out"
    "two_sheets two_sheets --side-by-side --frames 150 --out"
    "inspector inspector --frames 90 --out"
    "tangled tangled --frames 76 --out"
    "units tangled --unit 0 --frames 55 --out"
    "figure_6 paper_tables --largest 30 --runs 5 --figure"
)
for picture in "${pictures[@]}"; do
    read -r name example arguments <<<"$picture"
    if [ $# -eq 0 ] || [[ " $* " == *" $name "* ]]; then
        # shellcheck disable=SC2086
        cargo run --example "$example" -- $arguments "$out/$name.png"
    fi
done
