# Sourced by quickstart and check: numbered steps, long output kept in build/logs.
# The sourcing script sets `root` (the checkout) and `steps` (how many there will be).
# shellcheck shell=bash disable=SC2154

step_number=0

step() {
  step_number=$((step_number + 1))
  echo "[$step_number/$steps] $1"
}

# On a terminal, the newest line of what passes through, over and over in one place.
show_newest_line() {
  local line
  if [ -t 1 ]; then
    while IFS= read -r line; do printf '\r\033[K%.78s' "$line"; done
    printf '\r\033[K'
  else
    cat >/dev/null
  fi
}

# logged NAME COMMAND...: runs COMMAND with its output in build/logs/NAME.log; shows the log's
# end and returns 1 when COMMAND fails.
logged() {
  local name=$1 log=$root/build/logs/$1.log
  shift
  mkdir -p "${log%/*}"
  if ! "$@" 2>&1 </dev/null | tee "$log" | show_newest_line; then
    tail -n 30 "$log" >&2
    echo "$name failed; its whole output is in $log" >&2
    return 1
  fi
}
