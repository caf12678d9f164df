package Small "Small models, each with a law that a test states"
end Small;
