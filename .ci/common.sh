# Sourced by the scripts beside it: where things are, the flags of the builds, the two kinds of test
# and their count.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root" || exit 2
venv=$root/.venv
export PATH=$venv/bin:$PATH
# Python keeps what it compiles: without that each of many short programs compiles its imports.
unset PYTHONDONTWRITEBYTECODE

# FFTW of conda or Homebrew: pkg-config prints its folder, for the linker and for the loader.
fftw_folder=$(pkg-config --variable=libdir fftw3 2>/dev/null) || fftw_folder=
case $fftw_folder in
  '' | /usr/lib* | /lib*) ;;
  *)
    export LIBRARY_PATH=$fftw_folder${LIBRARY_PATH:+:$LIBRARY_PATH}
    export LD_RUN_PATH=$fftw_folder${LD_RUN_PATH:+:$LD_RUN_PATH}
    ;;
esac

# Every warning an error, every check on; fpm's own flags are left out on purpose. A number that
# nothing has set is a signalling NaN: its first use traps in the unit tests, which switch traps on.
# The program may meet a division by zero on its way and go on. Lines are counted, not optimised,
# because gcov leaves out lines of optimised code. With threads gcc would count by locked
# instructions, which takes five times as long; a count that two threads lose is still no 0.
# -fPIC: Python loads the same objects.
strict_flags="-std=f2008 -Wall -Wextra -Werror -O0 -g -fbacktrace -fcheck=all,no-array-temps \
-finit-real=snan -finit-derived --coverage -fprofile-update=single -fPIC"
# fpm's own, for objects that a shared library can be made of: the Python package has one. Archived
# IEEE output must not depend on what the processor offers: no contraction to fused multiply-add, no
# -march=native, no -ffast-math.
release_flags="-fPIC -fno-semantic-interposition -ffp-contract=off"
# Without optimisation gfortran computes with bounds of what is not allocated, whatever they are.
sanitize_flags="-O1 -g1 -fbacktrace -fno-omit-frame-pointer -fsanitize=address,undefined \
-fno-sanitize-recover=all"
# What flang-19 warns of is what it cannot fold in REAL(16).
second_flags="-O2 -ffp-contract=off -w"
second_compiler=flang-new-19

# fpm does not see a change in an included text (.inc): then it must build everything anew. Texts of
# the historic program are source files (.F90), whose changes it sees. It keeps
# the object of a removed file in its archive. Its folders are called COMPILER_HASH.
drop_stale_builds() {
  local texts sources
  texts=$(find src app test -name '*.inc' -exec cksum {} + | sort)
  if [ -f build/texts ] && [ "$(cat build/texts)" != "$texts" ]; then
    rm -rf build/*_????????????????
  fi
  echo "$texts" >build/texts
  sources=$(find src -name '*.[fF]90' | sort)
  if [ "$(cat build/sources 2>/dev/null)" != "$sources" ]; then
    rm -f build/*_????????????????/asperity/libasperity.a
    echo "$sources" >build/sources
  fi
}

kinds="release|strict|sanitize|images|second"
# Sets fpm_options to those of a build, and fpm_tests to what builds the unit tests with it.
# Without --no-prune fpm leaves out modules that nothing uses yet.
options_of() {
  fpm_tests=()
  case $1 in
    release) fpm_options=(--profile release --no-prune --flag "$release_flags") ;;
    strict) fpm_options=(--no-prune --flag "$strict_flags") ;;
    sanitize) fpm_options=(--no-prune --flag "$sanitize_flags") ;;
    images)
      # Not optimised, as the strict build: the same bytes. Profiles of fpm have -fcoarray=single.
      fpm_options=(--flag "-O0 $release_flags -DASPERITY_COARRAYS -fcoarray=lib"
        --link-flag "-Wl,--no-as-needed -lcaf_openmpi")
      ;;
    second)
      fpm_options=(--no-prune --compiler "$second_compiler" --c-compiler gcc --flag "$second_flags"
        --link-flag "$root/build/real128_functions.o -lquadmath -Wl,-z,muldefs")
      ;;
    *) return 1 ;;
  esac
  case $1 in
    strict | sanitize) fpm_tests=(--tests) ;;
  esac
}

# The last line 'N passed, M failed' of a log; nothing when there is none.
last_tally() {
  grep -E '^[0-9]+ passed, [0-9]+ failed$' "$1" | tail -n 1
}

# Packages of a group of requirements.txt, one a line.
requirements_of() {
  sed -n "s/^$1 //p" "$root/.ci/requirements.txt"
}

# The unit tests and the harness, and their count over several builds.
passed=0
failed=0

# Adds a tally 'N passed, M failed'. A status other than 0 without a failure told is one failure.
add() {
  local status=$1 name=$2 tally=$3 more=0
  [ -n "$tally" ] || tally="0 passed, 0 failed"
  passed=$((passed + ${tally%% passed*}))
  more=${tally#*, }
  more=${more%% failed*}
  if [ "$status" -ne 0 ] && [ "$more" -eq 0 ]; then
    echo "test: $name ended with status $status"
    more=1
  fi
  failed=$((failed + more))
}

# Starts the unit tests beside what comes next. Usage: start_units EXECUTABLE, of the same build.
start_units() {
  unit_log=${1%/app/*}/unit.log
  "${1%/app/*}/test/unit" >"$unit_log" 2>&1 &
  units=$!
}

# The same on counted lines. Counts of earlier sources go: libgcov complains of them.
start_counted_units() {
  find build -name '*.gcda' -delete
  start_units "$1"
}

# Waits for them, shows what they said, and counts them.
end_units() {
  local status tally
  wait "$units"
  status=$?
  cat "$unit_log"
  tally=$(last_tally "$unit_log")
  [ "$status" -ne 0 ] || [ -n "$tally" ] || status=1
  add "$status" "unit tests" "$tally"
}

# Folders of the harness: the longest tests first.
harness_folders=(test/hard test/maps test/effects test/contact test/original test/files
  test/interfaces test/pages)

# The harness on an executable, a process for each core, at most 8.
# Usage: harness EXECUTABLE [PYTEST OPTIONS]
harness() {
  local exe=$1
  shift
  harness_of "$exe" "${harness_folders[@]}" "$@"
}

# The same for the files and folders that are named. Usage: harness_of EXECUTABLE [PYTEST OPTIONS]
harness_of() {
  local exe=$1
  shift
  rm -f build/pytest.tally
  ASPERITY_EXE=$exe ASPERITY_TALLY=$root/build/pytest.tally \
    python -m pytest --rootdir "$root" -q -ra -n auto --maxprocesses 8 \
    --durations 10 --durations-min 5 "$@"
  add "$?" pytest "$(cat build/pytest.tally 2>/dev/null)"
}
