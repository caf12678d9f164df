"""One run: the tables that the loop works on, the loop itself, in Python and native, and its rows."""
