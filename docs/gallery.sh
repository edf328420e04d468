#!/usr/bin/env bash
# Draws every picture in docs/gallery from runs without a window: docs/gallery.sh [NAME ...]. Look at them before you commit them.
# Drawn twice by one build on one machine they have the same bytes, except those with times in them: inspector.png, crowd.png and figure_6.png.
set -euo pipefail
cd "$(dirname "$0")/.."
export BEVY_ASSET_ROOT="$PWD"
out=docs/gallery

# The picture, then the example and its arguments.
pictures=(
    "flag.gif flag --frames 240 --out"
    "drape.png drape --frames 240 --out"
    "net.gif net --frames 240 --out"
    "grab.png grab --frames 98 --out"
    "gltf.png gltf --frames 84 --out"
    "stack.png stack --frames 120 --out"
    "curtain.gif curtain --frames 240 --out"
    "character.png character --outfit dress --clip Turn --width 960 --frames 80 --out"
    "cape.png character --outfit cape --clip Run --width 960 --frames 90 --out"
    "dance.png character --outfit dress --clip Dance --width 960 --frames 90 --out"
    "crowd.png crowd --budget 60 --width 960 --frames 70 --out"
    "render_mesh.png render_mesh --frames 150 --out"
    "twist.gif twist --frames 240 --out"
    "funnel.gif funnel --frames 240 --out"
    "two_sheets.gif two_sheets --width 640 --frames 240 --out"
    "three_states.png two_sheets --side-by-side --frames 150 --out"
    "inspector.png inspector --frames 90 --out"
    "tangled.gif tangled --width 720 --frames 180 --out"
    "units.png tangled --unit 0 --frames 55 --out"
    "fabrics.png fabrics --width 1440 --frames 300 --out"
    "curtains.png fabrics --curtains --width 1440 --frames 420 --out"
    "specimens.png fabric_lab --quick --rate 360 --edge 0.005 --picture"
    "figure_6.png paper_tables --largest 30 --runs 5 --figure"
)
for picture in "${pictures[@]}"; do
    read -r file example arguments <<<"$picture"
    if [ $# -eq 0 ] || [[ " $* " == *" ${file%.*} "* ]]; then
        # shellcheck disable=SC2086
        cargo run --example "$example" -- $arguments "$out/$file"
    fi
done
