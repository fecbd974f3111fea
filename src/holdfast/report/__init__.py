"""Answers for people and programs: plain data for JSON, tables for the terminal, pictures. No physics here."""

from holdfast.report.picture import save_html, save_png
from holdfast.report.transport import save_polar

__all__ = ["save_html", "save_png", "save_polar"]
