"""Laws of contact, drag and slipstream for compiled equations."""
