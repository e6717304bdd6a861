"""How fast, accurate and robust is each part of Calot on this machine? One file a bench."""
