"""Parts: models that stand in other models, once or several times."""
