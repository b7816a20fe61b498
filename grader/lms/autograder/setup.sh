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

# Student code may read some files in these two folders, whichever user runs it. Only root may enter
# the folder that contains them, because it also contains the tests and the seed.
chown -R root:root .
chmod -R u=rwX,go=rX course python
chmod 700 .
cd course && ../python/bin/python -B -m grader.lms.autograder.jails /autograder/source
