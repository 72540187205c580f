# Sourced by the scripts beside it: where things are, and the flags of the builds.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root" || exit 2
venv=$root/.venv
export PATH=$venv/bin:$PATH

# Every warning an error, every check on; fpm's own flags are left out on purpose. A number that
# nothing has set is a signalling NaN: its first use traps.
strict_flags="-std=f2008 -Wall -Wextra -Werror -g -fbacktrace -fcheck=all,no-array-temps \
-ffpe-trap=invalid,zero,overflow -finit-real=snan -finit-derived"
# The same without traps, for the whole program: a solver may meet a division by zero on its way and
# go on.
checks_flags=${strict_flags/-ffpe-trap=invalid,zero,overflow/}
# Archived IEEE output must not depend on what the processor offers: no contraction to fused
# multiply-add, no -march=native, no -ffast-math.
archive_flags="-O2 -ffp-contract=off"
sanitize_flags="-O1 -g -fbacktrace -fno-omit-frame-pointer -fsanitize=address,undefined \
-fno-sanitize-recover=all"
memcheck_flags="-O1 -g -ffp-contract=off"
coverage_flags="-O0 -g --coverage"
# What flang-19 warns of is what it cannot fold in REAL(16).
second_flags="-O2 -ffp-contract=off -w"
second_compiler=flang-new-19

# fpm does not see a change in an included text: then it must build everything anew. Its folders
# are called COMPILER_HASH.
texts=$(find src app test -name '*.inc' -exec cksum {} + | sort)
if [ "$(cat build/texts 2>/dev/null)" != "$texts" ]; then
  rm -rf build/*_????????????????
  mkdir -p build
  echo "$texts" >build/texts
fi

# Sets fpm_options to those of a build: release|archive|strict|sanitize|memcheck|coverage|images|
# second.
# Without --no-prune fpm leaves out modules that nothing uses yet.
options_of() {
  case $1 in
    release) fpm_options=(--profile release) ;;
    archive) fpm_options=(--flag "$archive_flags") ;;
    strict) fpm_options=(--no-prune --flag "$strict_flags") ;;
    checks) fpm_options=(--no-prune --flag "$checks_flags") ;;
    sanitize) fpm_options=(--no-prune --flag "$sanitize_flags") ;;
    memcheck) fpm_options=(--no-prune --flag "$memcheck_flags") ;;
    images)
      fpm_options=(--flag "$archive_flags -DASPERITY_COARRAYS -fcoarray=lib"
        --link-flag "-Wl,--no-as-needed -lcaf_openmpi")
      ;;
    coverage) fpm_options=(--no-prune --flag "$coverage_flags") ;;
    second)
      fpm_options=(--no-prune --compiler "$second_compiler" --flag "$second_flags"
        --link-flag "$root/build/real128_functions.o -lquadmath -Wl,-z,muldefs")
      ;;
    *) return 1 ;;
  esac
}

# The last line 'N passed, M failed' of a log; nothing when there is none.
last_tally() {
  grep -E '^[0-9]+ passed, [0-9]+ failed$' "$1" | tail -n 1
}
