"""Answers for people and programs: plain data for JSON, tables for the terminal, pictures. No physics here."""
