# Run this cell first. It finds the course folder (in Colab, it downloads one) and checks it.
import os, sys; from pathlib import Path
folders = [p for p in (Path.cwd(), *Path.cwd().parents) if (p / "utils" / "checks").is_dir()]
fetch = "mkdir -p .new; curl -fsSL ADDRESS/archive/REVISION.tar.gz | tar -xzC .new --strip-components=1 --wildcards '*/data' '*/utils' 2>/dev/null && mv .new/* . && rmdir .new"
if not folders and "google.colab" in sys.modules and os.system(fetch) == 0:
    folders = [Path.cwd()]
assert folders, "The course files are missing. In Colab, check the connection and run this cell again. Elsewhere, unzip the whole course and open the notebook in its folder. The standalone notebook works without any other files."
sys.path.insert(0, str(folders[0])); hasattr(sys.modules.get("utils"), "begin") or sys.modules.pop("utils", None); import utils; utils.begin("NUMBER")
# ---
# Run this cell first. It finds the course folder and checks that nothing is missing.
import sys
from pathlib import Path
folders = [p for p in (Path.cwd(), *Path.cwd().parents) if (p / "utils" / "checks").is_dir()]
assert folders, "The folder `utils` is missing. Unzip the whole course and open the notebook in its folder, or use the standalone notebook, which works without any other files."
sys.path.insert(0, str(folders[0]))
hasattr(sys.modules.get("utils"), "begin") or sys.modules.pop("utils", None)  # another package of this name
import utils; utils.begin("NUMBER")
