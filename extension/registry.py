"""The course's additions to the grader; see `grader.course.extension`."""

from extension.league.command import add_league, league_links

COMMANDS = (add_league,)
REPORT_LINKS = (league_links,)
OPTIONAL_PACKAGES = (
    ("utils/breaking", "utils.breaking"),
    ("utils/by_hand", "utils.by_hand"),
    ("utils/drive", "utils.drive"),
    ("utils/drive/person.py", "utils.drive.person"),
    ("utils/replays", "replay"),
    ("utils/replays/clustering", "replay(euclidean_clustering)"),
    ("utils/replays/ransac", "replay(ransac_"),
)
