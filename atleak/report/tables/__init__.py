"""Write each answer once, as tables, sections and sentences that every medium prints."""
