"""From equations with constraints to ordinary ones, hidden constraint by hidden constraint."""
