"""The method of Nadeau & Kelly: slip by maximum flow, topple by cuts of the contact interface graph."""
