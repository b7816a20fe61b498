# Define `open_python FOLDER COMMAND...`, which lets another user run the Python in FOLDER even if
# it is in a private home folder. COMMAND switches to that user, who cannot see anything else in
# the home folder. Source this file in a separate mount namespace.
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
