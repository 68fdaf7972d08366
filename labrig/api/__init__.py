"""What `import labrig` offers: a function for each thing that the command line does, and what each gives back."""
