"""What people see: command line, tables, plots, report."""
