# Functions of quickstart and check: numbered steps, and log files in build/logs for long output.
# The script that sources this file sets `root` (the checkout) and `steps` (the number of steps).
# shellcheck shell=bash disable=SC2154

step_number=0

step() {
  step_number=$((step_number + 1))
  echo "[$step_number/$steps] $1"
}

# Reads lines. On a terminal, shows the newest line in place of the previous one.
show_newest_line() {
  local line
  if [ -t 1 ]; then
    while IFS= read -r line; do printf '\r\033[K%.78s' "$line"; done
    printf '\r\033[K'
  else
    cat >/dev/null
  fi
}

# logged NAME COMMAND...: runs COMMAND and writes its output to build/logs/NAME.log. If COMMAND
# fails, shows the end of the log and returns 1.
logged() {
  local name=$1 log=$root/build/logs/$1.log
  shift
  mkdir -p "${log%/*}"
  if ! "$@" 2>&1 </dev/null | tee "$log" | show_newest_line; then
    tail -n 30 "$log" >&2
    echo "$name failed: $log has the whole output" >&2
    return 1
  fi
}
