#!/bin/bash
# Two runs compared: the same panel mounted without tension, and stretched by 2 mm.
#
# compared.html says which keys and which results differ, and whether by more than chance; compared.json says the
# same to programs.
#
#     bash compare.sh [FOLDER]        # a new temporary folder by default
set -euo pipefail
out=${1:-$(mktemp -d)}

short=(--level draft --set duration_s=0.32 --set output.pictures=false)
flipflow run panel-cycle "${short[@]}" --out "$out/loose"
flipflow run panel-cycle "${short[@]}" --set "screen.panels.deck.tension_m=2 mm" --out "$out/stretched"

flipflow compare "$out/loose" "$out/stretched" --out "$out/compared.html" --json > "$out/compared.json"
