"""Page: what an experiment found, as an article."""

from hotlap.report.article import Article as Page
from hotlap.report.article import percent

__all__ = ["Page", "percent"]
