# Sourced by the scripts beside it: where things are, and the flags of the builds.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root" || exit 2
venv=$root/.venv
export PATH=$venv/bin:$PATH

# Every warning an error, every check on; fpm's own flags are left out on purpose.
strict_flags="-std=f2008 -Wall -Wextra -Werror -g -fbacktrace -fcheck=all \
-ffpe-trap=invalid,zero,overflow"
# Archived IEEE output must not depend on what the processor offers: no contraction to fused
# multiply-add, no -march=native, no -ffast-math.
archive_flags="-O2 -ffp-contract=off"

# fpm does not see a change in an included text: then it must build everything anew.
texts=$(cat src/*/*.inc | cksum)
if [ "$(cat build/texts 2>/dev/null)" != "$texts" ]; then
  rm -rf build/gfortran_*
  mkdir -p build
  echo "$texts" > build/texts
fi

# The last line 'N passed, M failed' of a log; nothing when there is none.
last_tally() {
  grep -E '^[0-9]+ passed, [0-9]+ failed$' "$1" | tail -n 1
}
