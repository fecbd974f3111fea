"""Ground truths of simple scenes, derived without the engines, against which the engines are measured."""
