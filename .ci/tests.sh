# Sourced after common.sh: the two kinds of test, and their count over several builds.
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
  "${1%/app/*}/test/unit" >build/unit.log 2>&1 &
  units=$!
}

# Waits for them, shows what they said, and counts them.
end_units() {
  local status tally
  wait "$units"
  status=$?
  cat build/unit.log
  tally=$(last_tally build/unit.log)
  [ "$status" -ne 0 ] || [ -n "$tally" ] || status=1
  add "$status" "unit tests" "$tally"
}

# Folders of the harness; hard cases, too, once there are any. They have the longest tests: first.
harness_folders() {
  if compgen -G 'test/hard/test_*.py' >/dev/null; then echo test/hard; fi
  echo test/regression
}

# The harness on an executable, a process for each core, at most 8.
# Usage: harness EXECUTABLE [PYTEST OPTIONS]
harness() {
  local exe=$1 folders
  shift
  mapfile -t folders < <(harness_folders)
  harness_of "$exe" "${folders[@]}" "$@"
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
