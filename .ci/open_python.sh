# Source this file in a separate mount namespace. A Python may be in a private home folder.
# `open_python FOLDER COMMAND...` lets the user that COMMAND switches to reach this Python, and nothing
# else in that folder.
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
