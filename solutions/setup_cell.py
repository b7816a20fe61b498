# Run this cell first. It finds the course's folder (Colab downloads it) and checks it.
import os, sys; from pathlib import Path
folders = [p for p in (Path.cwd(), *Path.cwd().parents) if (p / "utils" / "checks").is_dir()]
fetch = "mkdir -p .new; curl -fsSL ADDRESS/archive/REVISION.tar.gz | tar -xzC .new --strip-components=1 --wildcards '*/data' '*/utils' 2>/dev/null && mv .new/* . && rmdir .new"
if not folders and "google.colab" in sys.modules and os.system(fetch) == 0:
    folders = [Path.cwd()]
assert folders, "The course is not here. Check the connection and run this cell again, unzip the whole course and open the notebook in it, or use the standalone notebook, which needs no other file."
sys.path.insert(0, str(folders[0])); import utils; utils.begin("NUMBER")
# ---
# Run this cell first. It finds the course's folder and checks that nothing is missing.
import sys
from pathlib import Path

folders = [p for p in (Path.cwd(), *Path.cwd().parents) if (p / "utils" / "checks").is_dir()]
assert folders, "There is no folder `utils` here. Unzip the whole course and open the notebook in it, or use the standalone notebook, which needs no other file."
sys.path.insert(0, str(folders[0]))
import utils; utils.begin("NUMBER")
