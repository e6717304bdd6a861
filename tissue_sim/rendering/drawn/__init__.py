"""Which parts of the field are drawn? Each file draws one kind of object."""
