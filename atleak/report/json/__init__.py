"""Write a result as JSON, with the schema that it keeps."""
