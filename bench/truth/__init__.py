"""Ground truths of simple scenes, worked out without the engines: what the engines are measured against."""
