# Sourced in a mount namespace of one's own. A Python may lie in a home that is closed to others:
# open_python FOLDER COMMAND... lets whoever COMMAND becomes reach it, and nothing else there.
open_python() {
  local python="$1" closed="$1" elsewhere
  shift
  while [ "$closed" != / ] && ! "$@" test -x "$(dirname "$closed")"; do
    closed="$(dirname "$closed")"
  done
  if "$@" test -x "$closed"; then return; fi
  elsewhere="$(mktemp -d)"
  mount --bind "$python" "$elsewhere"
  mount -t tmpfs -o mode=755 none "$closed"
  mkdir -p "$python"
  mount --bind "$elsewhere" "$python"
}
