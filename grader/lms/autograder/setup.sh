#!/bin/sh
# Gradescope runs this once, as root, after the upload.
set -eu
cd /autograder/source

export DEBIAN_FRONTEND=noninteractive
apt-get update
apt-get install -y --no-install-recommends bubblewrap python3 python3-venv
python="$(command -v python3.13 || command -v python3.12 || command -v python3.11)" || {
  echo "This image has $(python3 -V). Choose one with Python 3.11 to 3.13, such as Ubuntu 24.04."
  exit 1
}

"$python" -m venv python
python/bin/pip install --quiet --disable-pip-version-check -r requirements.txt

# Student code is shown some files of these two, whoever runs it; and to this folder, in which
# tests and seed are, nobody comes but root.
chown -R root:root .
chmod -R u=rwX,go=rX course python
chmod 700 .
cd course && ../python/bin/python -B -m grader.lms.autograder.jails /autograder/source
