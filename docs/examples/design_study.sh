#!/bin/bash
# A design study: design_study.toml says what may be changed, what counts and what is limited; the best setting is
# found and measured again.
#
# design.html has the answer with its reasons; recommended.toml is a level of the case with the best setting, which
# "flipflow run --level" takes. Called again, the study makes only the runs that are missing.
#
#     bash design_study.sh [FOLDER]        # a new temporary folder by default
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=${1:-$(mktemp -d)}

flipflow study optimise "$here/design_study.toml" --out "$out/study" --workers 1
