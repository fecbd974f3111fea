"""Answers for people and programs: tables for the terminal, data for JSON, and pictures; there is no physics here."""
