"""What is integrated: motions and their equations in any algebra, system files, and closed forms."""
