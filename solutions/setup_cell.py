# Run this cell first. It finds the course's folder (Colab fetches it) and looks it over.
import os, sys; from pathlib import Path
folders = [p for p in (Path.cwd(), *Path.cwd().parents) if (p / "utils" / "checks").is_dir()]
fetch = "mkdir -p .new; curl -fsSL ADDRESS/archive/REVISION.tar.gz | tar -xzC .new --strip-components=1 --wildcards '*/data' '*/utils' 2>/dev/null && mv .new/* . && rmdir .new"
if not folders and "google.colab" in sys.modules and os.system(fetch) == 0:
    folders = [Path.cwd()]
assert folders, "No course here. Check the connection and run this cell again; or unzip the whole course and open the notebook from it; or get the standalone notebook, which needs no other file."
sys.path.insert(0, str(folders[0])); import utils; utils.begin("NUMBER")
# ---
# Run this cell first. It finds the course's folder and looks whether everything is there.
import sys
from pathlib import Path

folders = [p for p in (Path.cwd(), *Path.cwd().parents) if (p / "utils" / "checks").is_dir()]
assert folders, "No folder `utils` here: unzip the whole course and open the notebook from it; or get the standalone notebook, which needs no other file; or open the course by its address in Colab."
sys.path.insert(0, str(folders[0]))
import utils; utils.begin("NUMBER")
